#include "takt/serve/route_table.hpp"

#include <utility>

#include "takt/base/network.hpp"

namespace takt::serve {
namespace {

// FNV-1a. A connection has no other name than the text of its peer.
std::uint64_t hash_of(std::string_view text) {
    std::uint64_t hash = 14695981039346656037ULL;
    for (const char character : text) hash = (hash ^ static_cast<std::uint8_t>(character)) * 1099511628211ULL;
    return hash;
}

// Of the address without the port; of IPv6 its network, because one host may have a whole one.
std::uint64_t hash_of_owner(std::string_view peer) {
    const auto address = parse_peer(peer);
    if (!address) return hash_of(peer.substr(0, peer.rfind(':')));
    const IpAddress owner = rate_owner(*address);
    return hash_of({reinterpret_cast<const char*>(owner.bytes.data()), owner.bytes.size()});
}

}  // namespace

RouteTable::RouteTable(std::uint32_t server, std::vector<Upstream> upstreams,
                       const std::vector<Route>& routes)
    : server_(server), upstreams_(std::move(upstreams)) {
    for (const Route& route : routes)
        if (!has(route.from)) targets_[route.from.value] = {route.to, route.upstream};
}

std::optional<wire::Pdu> RouteTable::ask(const serve::Context& context, const wire::RequestView& request,
                                         serve::Token token) {
    const Target& target = targets_[context.unit.value];
    const Upstream& upstream = upstreams_[target.upstream];
    const Requester requester{server_, hash_of(context.peer), token, hash_of_owner(context.peer)};
    auto answer = upstream.gateway->ask(context.time, requester, upstream.policy, target.unit,
                                        wire::PreparedRequest(request));
    if (!answer && upstream.on_request) upstream.on_request();
    return answer;
}

RouteTarget RouteTable::target(UnitId unit) const {
    const Target& target = targets_[unit.value];
    return {target.unit, upstreams_[target.upstream].gateway->broadcasts(target.unit)};
}

std::optional<Fate> RouteTable::forget(serve::Token token) {
    for (const Upstream& upstream : upstreams_) {
        const bool withdrawn = withdraw(upstream, token);
        const auto fate = upstream.gateway->forget(server_, token);
        if (withdrawn && upstream.on_request) upstream.on_request();
        if (fate) return fate;
    }
    return std::nullopt;
}

bool RouteTable::refuse(serve::Token token, wire::ExceptionCode code) {
    for (const Upstream& upstream : upstreams_) {
        (void)withdraw(upstream, token);
        if (!upstream.gateway->refuse(server_, token, code)) continue;
        if (upstream.on_request) upstream.on_request();
        return true;
    }
    return false;
}

// Afterwards the line may take the next request.
bool RouteTable::withdraw(const Upstream& upstream, serve::Token token) const {
    if (!upstream.withdraw || !upstream.gateway->is_in_flight(server_, token)) return false;
    upstream.withdraw();
    return true;
}

}  // namespace takt::serve
