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
/// It is failing from kBegin failures in the window on, until there were fewer than kEnd for kQuiet and for
/// kWindow transactions. Of failures in a row only kMostInRow count: one outage makes no device failing.
/// Time must not run backwards. Never allocates.
class FailureShare {
public:
    enum class State : std::uint8_t { steady, failing };
    /// What the failures are. A device without an answer for kQuiet and kGone failures is not failing but
    /// silent.
    enum class Of : std::uint8_t { silence, refusal };
    static constexpr unsigned kWindow = 32;
    static constexpr int kBegin = 8;
    static constexpr int kEnd = 4;
    static constexpr unsigned kMostInRow = 3;
    static constexpr unsigned kGone = 8;
    static constexpr Duration kQuiet = std::chrono::seconds(30);

    explicit FailureShare(Of of) : of_(of) {}

    /// A transaction has ended.
    void ended(Instant t, bool answered);

    [[nodiscard]] State state() const { return since_ ? State::failing : State::steady; }
    /// State::failing: since when.
    [[nodiscard]] const std::optional<Instant>& since() const { return since_; }
    /// State::failing: of so many transactions, the window before it included, so many failed.
    [[nodiscard]] std::uint64_t failed() const { return failed_; }
    [[nodiscard]] std::uint64_t transactions() const { return transactions_; }

private:
    [[nodiscard]] int failures() const { return std::popcount(window_); }

    Of of_;
    std::uint32_t window_ = 0;  // a bit for each transaction, the last one lowest: it failed
    unsigned in_row_ = 0;       // failures
    Instant answered_at_ = Instant::min();
    Instant many_at_ = Instant::min();  // the window had kEnd failures
    unsigned few_ = 0;                  // transactions after that; at most kWindow
    std::uint64_t failed_ = 0;
    std::uint64_t transactions_ = 0;
    std::optional<Instant> since_;
};

}  // namespace takt::poll
