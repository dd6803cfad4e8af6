#include "takt/endpoint/line_gateway.hpp"

#include <utility>

#include "takt/base/assert.hpp"

namespace takt::endpoint {

LineGateway::LineGateway(const serve::GatewayConfig& config, SharedLine& line, Deliver deliver)
    : gateway_(config), line_(line), deliver_(std::move(deliver)) {}

void LineGateway::after_line_event(Instant t) {
    for (;;) {  // a request to a device that polling knows as not answering has its outcome at once
        while (const auto outcome = line_.take_outcome()) gateway_.on_outcome(*outcome);
        if (const bool up = line_.link_up(); up != std::exchange(up_, up)) gateway_.on_link(up);
        const auto may_start = [&](UnitId unit, const bus::AnswerShape& shape) {
            return line_.may_start(t, unit, shape);
        };
        if (gateway_.should_withdraw(may_start)) withdraw();
        if (!line_.can_accept()) return;
        const auto next = gateway_.next(t, may_start);
        if (!next) return;
        if (!line_.submit(t, *next))
            gateway_.on_outcome({.id = next->id, .unit = next->unit, .status = bus::Status::cancelled});
    }
}

void LineGateway::withdraw() {
    if (line_.withdraw()) gateway_.on_withdrawn();
}

void LineGateway::take_back() {
    while (const auto outcome = line_.take_outcome()) gateway_.on_outcome(*outcome);
    withdraw();
    TAKT_ASSERT(!gateway_.under_way());
}

void LineGateway::work(Instant t) {
    gateway_.on_tick(t);
    after_line_event(t);
    line_.poke();
    while (const auto reply = gateway_.take_reply()) deliver_(*reply);
}

Instant LineGateway::next_wakeup(Instant t) const {
    const bool can_go_on = line_.can_accept() && gateway_.has_next();
    return gateway_.has_replies() || can_go_on ? t : gateway_.next_wakeup();
}

}  // namespace takt::endpoint
