// When a line's requests are sent: a round in time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// What a transaction is made of, in this order (docs/planning.md, bus time). Without a silence on the line
/// (ASCII, TCP) that part is empty; on TCP the turnaround is the round trip; the pause stretches it to
/// request_gap.
enum class Part : std::uint8_t { silence, request, turnaround, response, pause };
inline constexpr std::size_t kParts = 5;

/// One transaction.
struct Bar {
    std::size_t request = 0;  ///< index into the plan's requests
    Duration due{};           ///< when it was to be sent; its own start where it is sent without pause
    Duration start{};
    /// Where each part ends, from `start`; rounded up to nanoseconds, the last is the request's bus time.
    std::array<Duration, kParts> ends{};

    [[nodiscard]] Duration end() const { return start + ends.back(); }
    [[nodiscard]] Duration begin_of(Part part) const {
        return part == Part::silence ? start : start + ends[static_cast<std::size_t>(part) - 1];
    }
    [[nodiscard]] Duration end_of(Part part) const { return start + ends[static_cast<std::size_t>(part)]; }
};

/// How much of the time is looked at.
struct RoundWindow {
    Duration length{};
    /// After which all dues come again, at most Duration::max(); zero where nothing has a period.
    Duration repeats{};
    /// The whole of it: a hyperperiod, or one round of what has no period.
    bool whole = true;
};

/// One hyperperiod, at most 100 of the shortest periods, and at least one round.
[[nodiscard]] RoundWindow round_window(const LinePlan& plan);

struct Timeline {
    Duration window{};      ///< bars begin before its end
    std::vector<Bar> bars;  ///< by start; none overlaps the next
    bool cut = false;       ///< there would be more bars in the window
};

/// The polling of one line as the master sends it when every transaction takes its bus time and nothing
/// fails: each request is due at phase + n * period, the most urgent of those due goes first and is not
/// interrupted. Most urgent is the least deadline, ties in the order of the plan; with `order: address` the
/// next in the round. What has waited beyond its deadline goes before (`order: deadline`), a missed due is
/// left out, and what has period 0 takes turns in the idle time. Writes and triggers cause no bars; requests
/// in flight together (TCP) are laid one after the other, so what is shown is the slowest the line can be.
/// O(bars * requests).
/// @param most_bars  greatest number of bars
[[nodiscard]] Timeline timeline(const model::Line& line, const LinePlan& plan, Duration window,
                                std::size_t most_bars);

}  // namespace takt::plan
