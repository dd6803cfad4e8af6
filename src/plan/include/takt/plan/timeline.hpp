// The schedule of a line's requests over one round.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The parts of a transaction, in order (docs/planning.md, "Bus time"). Without silences (ASCII, TCP) that
/// part is empty. On TCP the turnaround is the round trip. The pause stretches the transaction to
/// request_gap.
enum class Part : std::uint8_t { silence, request, turnaround, response, pause };
inline constexpr std::size_t kParts = 5;

/// One transaction.
struct Bar {
    std::size_t request = 0;  ///< index into the plan's requests
    Duration due{};           ///< due time; for period 0 its own start
    Duration start{};
    bool late = false;  ///< ends after its deadline; never of period 0
    /// The end of each part, from `start`, rounded up to nanoseconds. The last one is the bus time.
    std::array<Duration, kParts> ends{};

    [[nodiscard]] Duration end() const { return start + ends.back(); }
    [[nodiscard]] Duration begin_of(Part part) const {
        return part == Part::silence ? start : start + ends[static_cast<std::size_t>(part) - 1];
    }
    [[nodiscard]] Duration end_of(Part part) const { return start + ends[static_cast<std::size_t>(part)]; }
};

/// The window of a timeline.
struct RoundWindow {
    Duration length{};
    /// The hyperperiod, at most Duration::max(); zero without periods.
    Duration repeats{};
    /// A hyperperiod, or one round of the requests without a period.
    bool whole = true;
};

/// A hyperperiod, limited to 100 of the shortest periods, and at least one round.
[[nodiscard]] RoundWindow round_window(const LinePlan& plan);

struct Timeline {
    Duration window{};      ///< bars begin before its end
    std::vector<Bar> bars;  ///< by start; none overlaps the next
    bool cut = false;       ///< there would be more bars in the window
};

/// The polling of one line as the master sends it, if every transaction takes its bus time and nothing fails.
///   - A request is due at phase + n * period. The most urgent due request is sent and not interrupted.
///   - `order: deadline`: the least deadline first, ties in the order of the plan; overdue requests go before
///     all others. `order: address`: the next one in the round.
///   - A missed due time is skipped. Requests with period 0 alternate in the idle time.
/// Writes and triggers have no bars. Requests in flight together (TCP) are shown one after the other, so the
/// result is the slowest possible schedule. O(bars * requests).
/// @param most_bars  limit of the number of bars
[[nodiscard]] Timeline timeline(const model::Line& line, const LinePlan& plan, Duration window,
                                std::size_t most_bars);

}  // namespace takt::plan
