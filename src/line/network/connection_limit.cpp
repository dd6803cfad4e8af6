#include "takt/line/connection_limit.hpp"

#include <algorithm>

namespace takt::line {

ConnectionLimit::Permit ConnectionLimit::ask(const std::string& host, std::size_t most,
                                             std::function<void()> admitted) {
    auto& connections = hosts_[host];
    Permit permit(this, host, ++last_ticket_);
    if (connections.waiting.empty() && connections.taken < most) {
        ++connections.taken;
        admitted();
        return permit;
    }
    connections.waiting.push_back({last_ticket_, most, std::move(admitted)});
    if (on_wanted_) on_wanted_(host);
    return permit;
}

bool ConnectionLimit::wanted(const std::string& host) const {
    const auto found = hosts_.find(host);
    return found != hosts_.end() && !found->second.waiting.empty();
}

// One that waits gives back nothing.
void ConnectionLimit::leave(const std::string& host, std::uint64_t ticket) {
    auto& connections = hosts_[host];
    const auto waits = std::ranges::find(connections.waiting, ticket, &Waiting::ticket);
    if (waits != connections.waiting.end()) {
        connections.waiting.erase(waits);
        return;
    }
    --connections.taken;
    if (connections.waiting.empty() || connections.taken >= connections.waiting.front().most) return;
    auto next = std::move(connections.waiting.front());
    connections.waiting.pop_front();
    ++connections.taken;
    next.admitted();
}

}  // namespace takt::line
