#include "takt/relay/relay_responder.hpp"

#include <utility>

namespace takt::relay {
namespace {

// FNV-1a. The text is all a connection is known by.
std::uint64_t client_of(std::string_view peer) {
    std::uint64_t hash = 14695981039346656037ULL;
    for (const char character : peer) hash = (hash ^ static_cast<std::uint8_t>(character)) * 1099511628211ULL;
    return hash;
}

}  // namespace

RelayResponder::RelayResponder(std::uint32_t server, serve::Responder* own, serve::Tokens& tokens,
                               std::vector<Way> ways, const std::vector<Route>& routes)
    : server_(server), own_(own), tokens_(tokens), ways_(std::move(ways)) {
    for (const Route& route : routes) {
        Target& target = targets_[route.from.value];
        if (!target.way) target = {route.to, &ways_[route.way]};
    }
}

bool RelayResponder::serves(UnitId unit) const {
    return (own_ && own_->serves(unit)) || targets_[unit.value].way;
}

serve::Answer RelayResponder::handle(const serve::Context& context, Bytes pdu) {
    const Target& target = targets_[context.unit.value];
    if (context.broadcast) {
        if (own_) (void)own_->handle(context, pdu);
        if (target.way) (void)pass_on(context, target, pdu);
        return {};
    }
    const bool is_own = own_ && own_->serves(context.unit);
    if (!is_own && target.way) return pass_on(context, target, pdu);
    if (own_) return own_->handle(context, pdu);
    return serve::Answer::response(
        serve::exception_to(pdu[0], wire::ExceptionCode::gateway_path_unavailable));
}

serve::Answer RelayResponder::pass_on(const serve::Context& context, const Target& target, Bytes pdu) {
    const Way& way = *target.way;
    const serve::Token token = tokens_.next();
    const Asker asker{server_, client_of(context.peer), token};
    if (const auto answer = way.gateway->ask(context.time, asker, way.treatment, target.unit, pdu))
        return serve::Answer::response(*answer);
    if (way.asked) way.asked();
    return serve::Answer::pending(token);
}

void RelayResponder::heard(serve::LineEvent event) {
    if (own_) own_->heard(event);
}

void RelayResponder::forget(serve::Token token) {
    if (own_) own_->forget(token);
    for (const Way& way : ways_) way.gateway->forget(server_, token);
}

}  // namespace takt::relay
