#include "takt/line/host_places.hpp"

#include <algorithm>

namespace takt::line {

HostPlaces::Place HostPlaces::ask(const std::string& host, std::size_t most, std::function<void()> admitted) {
    auto& places = hosts_[host];
    Place place(this, host, ++last_ticket_);
    if (places.waiting.empty() && places.taken < most) {
        ++places.taken;
        admitted();
        return place;
    }
    places.waiting.push_back({last_ticket_, most, std::move(admitted)});
    if (on_wanted_) on_wanted_(host);
    return place;
}

bool HostPlaces::wanted(const std::string& host) const {
    const auto found = hosts_.find(host);
    return found != hosts_.end() && !found->second.waiting.empty();
}

// One that waits gives back nothing.
void HostPlaces::leave(const std::string& host, std::uint64_t ticket) {
    auto& places = hosts_[host];
    const auto waits = std::ranges::find(places.waiting, ticket, &Waiting::ticket);
    if (waits != places.waiting.end()) {
        places.waiting.erase(waits);
        return;
    }
    --places.taken;
    if (places.waiting.empty() || places.taken >= places.waiting.front().most) return;
    auto next = std::move(places.waiting.front());
    places.waiting.pop_front();
    ++places.taken;
    next.admitted();
}

}  // namespace takt::line
