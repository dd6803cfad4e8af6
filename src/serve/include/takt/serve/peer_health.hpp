// Which units answer which peers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/health.hpp"

namespace takt::serve {

/// The back-off of units that do not answer (bus::Health), for each peer by itself: a peer that asks a unit
/// for what it never answers does not shut it off from the others.
///
/// Knows kMost pairs of a unit and a peer. A further one replaces the pair that may ask again first.
class PeerHealth {
public:
    static constexpr std::size_t kMost = 256;

    /// @param attempts  failures in a row after which a unit counts as not answering
    explicit PeerHealth(std::uint16_t attempts);

    void answered(UnitId unit, std::uint64_t peer);
    void failed(Instant t, UnitId unit, std::uint64_t peer);
    /// Forgets all.
    void clear() { failing_.clear(); }

    [[nodiscard]] bool answering(UnitId unit, std::uint64_t peer) const;
    /// When that peer's next request to the unit may be sent. The past where it answers.
    [[nodiscard]] Instant probe_at(UnitId unit, std::uint64_t peer) const;

private:
    struct Failing {
        UnitId unit;
        std::uint64_t peer = 0;
        bus::Health health;
    };
    [[nodiscard]] const Failing* find(UnitId unit, std::uint64_t peer) const;

    std::uint16_t attempts_;
    std::vector<Failing> failing_;
};

}  // namespace takt::serve
