// What closed connections say about the devices behind them.
#pragma once

#include <algorithm>
#include <bitset>
#include <cstddef>

#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::poll {

/// Finds out what a peer closes its connections for.
///
/// A close while one request waits is a failure of the unit that was asked. If several wait, no unit is
/// charged: they are sent one at a time until a close names one of them, or so many have ended without one.
/// Each time none was named, that number doubles: the peer does not like several at a time.
///
/// If no unit answers in between, and each unit that is still asked has met a close, it is the line's fault.
///
/// One owner, one thread. Never allocates.
class CloseWatch {
public:
    static constexpr std::size_t kMostAlone = 1024;

    /// The connection was closed while so many requests waited for their responses.
    void closed(std::size_t waiting) {
        if (waiting == 0) return;
        if (waiting == 1) {
            alone_ = next_alone_ = 0;
            return;
        }
        alone_ = next_alone_ = std::min(std::max(2 * next_alone_, waiting), kMostAlone);
    }
    /// A request that was sent has ended.
    void ended(const bus::Outcome& outcome) {
        if (outcome.status == bus::Status::closed) row_.set(outcome.unit.value);
        // A response that may be that to an earlier request shows that the line works, too.
        if (!outcome.response.empty() || outcome.status == bus::Status::ambiguous) row_.reset();
        if (alone_ > 0 && outcome.status != bus::Status::link_lost) --alone_;
    }
    void reset() { row_.reset(); }

    /// Requests are sent one at a time.
    [[nodiscard]] bool one_at_a_time() const { return alone_ > 0; }
    /// Several units have met a close since one answered.
    [[nodiscard]] bool met_by_several() const { return row_.count() > 1; }
    [[nodiscard]] bool met_by(UnitId unit) const { return row_.test(unit.value); }

private:
    std::bitset<256> row_;  // units that met a close since one answered
    std::size_t alone_ = 0;
    std::size_t next_alone_ = 0;
};

}  // namespace takt::poll
