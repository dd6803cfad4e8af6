// What a unit has shown of its response times, as far as the engine needs it
// (docs/decisions/0032-in-step.md).
#pragma once

#include <array>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/bus/outstanding_responses.hpp"
#include "takt/bus/step_watch.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// From the end of the request, computed from the bit rate, to the first byte of the response, computed from
/// the arrival of its last byte and its length. Over a stream: from sending to arrival.
/// @param outcome  ok, exception or ambiguous
[[nodiscard]] Duration response_delay(const LineConfig& config, const Outcome& outcome);

/// The times of one unit. One owner, one thread.
struct UnitTimes {
    std::optional<Duration> longest_delay;  ///< of responses in time; falls slowly
    Duration lateness{};                    ///< the longest delay of a late response
    std::array<Duration, 3> last_late{};    ///< the delays of the last ones; zero: not so many
    bool in_order = true;                   ///< it answers requests in their order
    bool missing = false;                   ///< a response is, since the last late one
    StepWatch step;

    /// A response in time.
    /// @param certain  it answers the last request: no other response of the unit is missing. Others shorten
    ///                 nothing, and lengthen slowly
    void on_response(Duration delay, bool certain);
    /// No response in time.
    void on_missing() { missing = true; }
    void on_late(const LateResponse& late);

    /// The median of the last three; zero if there are not so many. A frame may be taken for a late response
    /// that is none, and then shows any delay.
    [[nodiscard]] Duration usual_lateness() const;

    /// Sets what the transaction knows of its unit: late_limit, lateness, patience, longest_delay, in_order.
    /// @param response_timeout  of the device: the least late_limit, and an eighth of the greatest
    void set(Transaction& transaction, Duration response_timeout) const;
};

}  // namespace takt::bus
