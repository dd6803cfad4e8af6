#include "takt/endpoint/gateway_set.hpp"

#include <algorithm>
#include <utility>

namespace takt::endpoint {
namespace {

serve::RequestPolicy policy_of(const model::Relay& relay) {
    return {.cache = relay.cache,
            .attempts = relay.attempts,
            .max_wait = relay.max_wait,
            .response_timeout = relay.response_timeout};
}

/// `map` before `units`, each relay's before the next one's.
std::vector<serve::Route> routes_of(const std::vector<model::Relay>& relays) {
    std::vector<serve::Route> routes;
    for (std::size_t i = 0; i < relays.size(); ++i) {
        for (const auto [from, to] : relays[i].map) routes.push_back({from, to, i});
        for (const auto [first, last] : relays[i].units)
            for (unsigned unit = first; unit <= last; ++unit) {
                const UnitId same{static_cast<std::uint8_t>(unit)};
                routes.push_back({same, same, i});
            }
    }
    return routes;
}

}  // namespace

struct GatewaySet::Line {
    Line(GatewaySet& set, const model::Line& settings, SharedLine& line)
        : gateway({.broadcast = settings.framing != wire::Framing::tcp}, line, set.deliver_),
          timer(set.loop_, [this](Instant t) {
              gateway.work(t);
              timer.set(gateway.next_wakeup(t));
          }) {}

    LineGateway gateway;
    line::Timer timer;
};

GatewaySet::GatewaySet(line::Loop& loop, LineGateway::Deliver deliver)
    : loop_(loop), deliver_(std::move(deliver)) {}

GatewaySet::~GatewaySet() = default;

void GatewaySet::add(std::size_t index, const model::Line& settings, SharedLine& line) {
    if (lines_.size() <= index) lines_.resize(index + 1);
    lines_[index] = std::make_unique<Line>(*this, settings, line);
}

void GatewaySet::take_back() {
    for (const auto& line : lines_)
        if (line) line->gateway.take_back();
}

void GatewaySet::renumber(const model::Continued& before) {
    auto old = std::exchange(lines_, std::vector<std::unique_ptr<Line>>(before.size()));
    for (std::size_t i = 0; i < before.size(); ++i) {
        if (!before[i] || *before[i] >= old.size()) continue;
        lines_[i] = std::move(old[*before[i]]);
        if (lines_[i]) lines_[i]->timer.set(line::now());
    }
}

serve::RouteTable GatewaySet::routes(std::uint32_t endpoint, const std::vector<model::Relay>& relays) {
    std::vector<serve::Upstream> upstreams;
    for (const auto& relay : relays) {
        Line& line = *lines_[relay.line];
        upstreams.push_back({&line.gateway.gateway(), policy_of(relay),
                             [&line] { line.timer.set(line::now()); }, [&line] { line.gateway.withdraw(); }});
    }
    return {endpoint, std::move(upstreams), routes_of(relays)};
}

void GatewaySet::after_line_event(Instant t, std::size_t index) {
    if (!has(index)) return;
    Line& line = *lines_[index];
    line.gateway.after_line_event(t);
    line.timer.set(line.gateway.next_wakeup(t));
}

std::vector<GatewayStatistics> GatewaySet::statistics() const {
    std::vector<GatewayStatistics> all;
    for (std::size_t i = 0; i < lines_.size(); ++i)
        if (lines_[i]) all.push_back({i, lines_[i]->gateway.gateway().counters()});
    return all;
}

void GatewaySet::refresh(std::vector<GatewayStatistics>& statistics) const {
    for (auto& line : statistics) line.counters = lines_[line.line]->gateway.gateway().counters();
}

std::vector<UnitId> relayed_units(const std::vector<model::Relay>& relays) {
    std::vector<UnitId> units;
    for (const auto& route : routes_of(relays)) units.push_back(route.from);
    std::ranges::sort(units);
    const auto surplus = std::ranges::unique(units);
    units.erase(surplus.begin(), surplus.end());
    return units;
}

}  // namespace takt::endpoint
