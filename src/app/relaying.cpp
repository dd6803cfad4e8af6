#include "relaying.hpp"

#include <algorithm>
#include <utility>

namespace takt::app {
namespace {

relay::GatewayConfig config_of(const model::Line& line) {
    return {.broadcast = line.framing != wire::Framing::tcp};
}

relay::Treatment treatment_of(const model::Relay& relay) {
    return {.cache = relay.cache,
            .attempts = relay.attempts,
            .max_wait = relay.max_wait,
            .response_timeout = relay.response_timeout};
}

std::vector<relay::Route> routes_of(const model::Server& server) {
    std::vector<relay::Route> routes;
    for (std::size_t way = 0; way < server.relays.size(); ++way) {
        for (const auto [from, to] : server.relays[way].map) routes.push_back({from, to, way});
        for (const auto [first, last] : server.relays[way].units)
            for (unsigned unit = first; unit <= last; ++unit) {
                const UnitId same{static_cast<std::uint8_t>(unit)};
                routes.push_back({same, same, way});
            }
    }
    return routes;
}

/// Keeps the own units alive that its responder asks.
struct RelayingServer {
    std::shared_ptr<serve::Responder> own;
    relay::RelayResponder responder;
};

}  // namespace

struct Relaying::Line {
    Line(line::Loop& loop, const model::Line& line, std::function<void(Instant)> work)
        : gateway(config_of(line)), timer(loop, std::move(work)) {}

    relay::Gateway gateway;
    line::Timer timer;
    bool up = false;
};

Relaying::Relaying(line::Loop& loop, const model::Project& project, Running& running)
    : loop_(loop),
      project_(project),
      running_(running),
      lines_(project.lines.size()),
      answers_(project.servers.size()) {
    for (std::size_t i = 0; i < lines_.size(); ++i)
        if (project.lines[i].relayed)
            lines_[i] = std::make_unique<Line>(loop_, project.lines[i], [this, i](Instant t) { work(t, i); });
    running_.watch_lines([this](Instant t, std::size_t line) {
        if (!lines_[line]) return;
        exchange(t, line);
        arm(t, line);
    });
}

Relaying::~Relaying() {
    running_.watch_lines({});
}

std::shared_ptr<serve::Responder> Relaying::responder(std::size_t index,
                                                      std::shared_ptr<serve::Responder> own,
                                                      line::AnswerRoutes& answers) {
    const model::Server& server = project_.servers[index];
    answers_[index] = &answers;
    if (server.relays.empty()) return own;
    std::vector<relay::RelayResponder::Way> ways;
    for (const auto& relay : server.relays) {
        Line& line = *lines_[relay.line];
        ways.push_back({&line.gateway, treatment_of(relay), [&line] { line.timer.set(line::now()); }});
    }
    serve::Responder* const asked = server.units.empty() ? nullptr : own.get();
    auto made = std::make_shared<RelayingServer>(
        std::move(own), relay::RelayResponder(static_cast<std::uint32_t>(index), asked, answers.tokens(),
                                              std::move(ways), routes_of(server)));
    return {made, &made->responder};
}

std::vector<UnitId> Relaying::units(std::size_t server) const {
    std::vector<UnitId> units;
    for (const auto& route : routes_of(project_.servers[server])) units.push_back(route.from);
    std::ranges::sort(units);
    const auto more = std::ranges::unique(units);
    units.erase(more.begin(), more.end());
    return units;
}

const relay::GatewayCounters* Relaying::counters(std::size_t line) const {
    return lines_[line] ? &lines_[line]->gateway.counters() : nullptr;
}

void Relaying::exchange(Instant t, std::size_t index) {
    Line& line = *lines_[index];
    poll::LinePoller& poller = running_.line(index);
    while (const auto outcome = poller.take_relayed()) line.gateway.on_outcome(*outcome);
    if (std::exchange(line.up, poller.link_up()) != line.up) line.gateway.on_link(line.up);
    if (!poller.can_relay()) return;
    const auto next = line.gateway.next(t);
    if (!next || poller.relay(t, *next)) return;
    line.gateway.on_outcome({.id = next->id, .unit = next->unit, .status = bus::Status::cancelled});
}

void Relaying::work(Instant t, std::size_t index) {
    Line& line = *lines_[index];
    line.gateway.on_tick(t);
    exchange(t, index);
    running_.poke_line(index);
    deliver(line);
    arm(t, index);
}

// By all that there is to do: whoever was just given an answer may have asked again.
void Relaying::arm(Instant t, std::size_t index) {
    Line& line = *lines_[index];
    const bool can_go_on = running_.line(index).can_relay() && line.gateway.has_next();
    line.timer.set(line.gateway.has_replies() || can_go_on ? t : line.gateway.next_wakeup());
}

// A client may have gone in the meantime; then its answer is nobody's.
void Relaying::deliver(Line& line) {
    while (const auto reply = line.gateway.take_reply())
        (void)answers_[reply->server]->complete(reply->token, reply->pdu.span());
}

}  // namespace takt::app
