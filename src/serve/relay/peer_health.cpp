#include "takt/serve/peer_health.hpp"

#include <algorithm>

namespace takt::serve {

PeerHealth::PeerHealth(std::uint16_t attempts) : attempts_(attempts) {
    failing_.reserve(kMost);
}

const PeerHealth::Failing* PeerHealth::find(UnitId unit, std::uint64_t peer) const {
    const auto found = std::ranges::find_if(
        failing_, [&](const Failing& failing) { return failing.unit == unit && failing.peer == peer; });
    return found == failing_.end() ? nullptr : &*found;
}

void PeerHealth::answered(UnitId unit, std::uint64_t peer) {
    if (const Failing* const found = find(unit, peer))
        failing_.erase(failing_.begin() + (found - failing_.data()));
}

void PeerHealth::failed(Instant t, UnitId unit, std::uint64_t peer) {
    const Failing* const found = find(unit, peer);
    std::size_t index = found ? static_cast<std::size_t>(found - failing_.data()) : failing_.size();
    if (!found && failing_.size() < kMost) {
        failing_.push_back({unit, peer, bus::Health(attempts_)});
    } else if (!found) {
        const auto soonest = std::ranges::min_element(
            failing_, {}, [](const Failing& failing) { return failing.health.probe_at(); });
        index = static_cast<std::size_t>(soonest - failing_.begin());
        *soonest = {unit, peer, bus::Health(attempts_)};
    }
    (void)failing_[index].health.failed(t);
}

bool PeerHealth::answering(UnitId unit, std::uint64_t peer) const {
    const Failing* const found = find(unit, peer);
    return !found || found->health.answering();
}

Instant PeerHealth::probe_at(UnitId unit, std::uint64_t peer) const {
    const Failing* const found = find(unit, peer);
    return found ? found->health.probe_at() : Instant::min();
}

}  // namespace takt::serve
