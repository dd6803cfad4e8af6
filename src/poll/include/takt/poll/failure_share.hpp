// Whether a device that answers fails often.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "takt/base/time.hpp"

namespace takt::poll {

/// The share of failures among the last kWindow transactions of a device, with hysteresis: a device that
/// answers some requests only stays `failing` while it stops and begins to answer again and again.
///
/// It is failing from kBegin failures in the window on, until there were fewer than kEnd for kQuiet. Of
/// failures in a row only kMostInRow count: one outage makes no device failing. A device without an answer
/// for kQuiet and kGone failures is not failing but silent. Time must not run backwards. Never allocates.
class FailureShare {
public:
    enum class State : std::uint8_t { steady, failing };
    static constexpr unsigned kWindow = 32;
    static constexpr int kBegin = 8;
    static constexpr int kEnd = 4;
    static constexpr unsigned kMostInRow = 3;
    static constexpr unsigned kGone = 8;
    static constexpr Duration kQuiet = std::chrono::seconds(30);

    /// A transaction has ended.
    void ended(Instant t, bool answered);

    [[nodiscard]] State state() const { return since_ ? State::failing : State::steady; }
    /// State::failing: since when.
    [[nodiscard]] const std::optional<Instant>& since() const { return since_; }

private:
    [[nodiscard]] int failures() const { return std::popcount(window_); }

    std::uint32_t window_ = 0;  // a bit for each transaction, the last one lowest: it failed
    unsigned in_row_ = 0;       // failures
    Instant answered_at_ = Instant::min();
    Instant many_at_ = Instant::min();  // the window had kEnd failures
    std::optional<Instant> since_;
};

}  // namespace takt::poll
