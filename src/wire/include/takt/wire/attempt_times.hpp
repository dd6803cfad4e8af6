// How long a request waits for its response, and how long an attempt without a response takes the line.
#pragma once

namespace takt::wire {

/// The times of one attempt. The deadline of the engine, the early probes and the proof follow from them
/// (docs/guarantees.md, "Model": the time-out and F).
/// @tparam Time  Duration; in the proof an exact time, which is rounded later
template <typename Time>
struct AttemptTimes {
    Time request{};   ///< the characters of the request
    Time wait{};      ///< response_wait(): the longest time from its end to the first byte of the response
    Time response{};  ///< the characters of the longest normal response
    Time margin{};    ///< LineConfig::margin
    Time silence{};   ///< the least silence before the next request

    /// From the end of the request to its deadline.
    [[nodiscard]] constexpr Time time_out() const { return wait + response + margin; }
    /// From the start of the request until the next one may start. request_gap is not considered.
    /// @param rounded  time_out(), as the caller rounds it
    [[nodiscard]] constexpr Time failure(Time rounded) const { return request + rounded + silence; }
    [[nodiscard]] constexpr Time failure() const { return failure(time_out()); }
};

}  // namespace takt::wire
