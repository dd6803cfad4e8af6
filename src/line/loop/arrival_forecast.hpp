// When the next event of a loop is expected.
#pragma once

#include <array>
#include <cstddef>

#include "takt/base/time.hpp"

namespace takt::line {

/// Masters poll in cycles. The arrivals of a loop are then a sequence that repeats after one arrival, or
/// after as many as the masters send in a cycle: the spans between arrivals that are one cycle apart agree.
/// The forecast uses the cycle for which most of them do; of several, the shortest.
class ArrivalForecast {
public:
    static constexpr std::size_t kLongestCycle = 8;  ///< arrivals
    static constexpr std::size_t kSpans = 8;         ///< compared
    static constexpr std::ptrdiff_t kAgreeing = 6;   ///< of them, at least

    /// @param tolerance  spans that differ from their median by at most this agree; > 0
    explicit ArrivalForecast(Duration tolerance) : tolerance_(tolerance) {}

    /// @param t  of one or several events at once; not before the last one
    void on_arrival(Instant t);
    /// Also an instant that has passed: the expected arrival is late. kNever: no steady cycle.
    [[nodiscard]] Instant next() const { return next_; }

private:
    using Spans = std::array<Duration, kSpans>;

    [[nodiscard]] Instant arrival(std::size_t ago) const;
    [[nodiscard]] Spans spans(std::size_t cycle) const;
    [[nodiscard]] Instant expected() const;

    Duration tolerance_;
    std::array<Instant, kLongestCycle + kSpans> arrivals_{};  // a ring
    std::size_t count_ = 0;
    Instant next_ = kNever;
};

}  // namespace takt::line
