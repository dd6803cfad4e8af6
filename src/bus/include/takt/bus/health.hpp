// Whether a device answers, and when a device that does not is probed again.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "takt/base/time.hpp"

namespace takt::bus {

/// Exponential back-off: waiting times that double from `first` up to `limit`.
class Backoff {
public:
    constexpr Backoff(Duration first, Duration limit) : first_(first), limit_(limit), next_(first) {}

    constexpr Duration next() {
        const Duration wait = next_;
        next_ = std::min(2 * next_, limit_);
        return wait;
    }
    constexpr void reset() { next_ = first_; }
    [[nodiscard]] constexpr Duration first() const { return first_; }

private:
    Duration first_;
    Duration limit_;
    Duration next_;
};

constexpr Backoff probe_backoff() {
    return {std::chrono::seconds(1), std::chrono::seconds(60)};
}
constexpr Backoff busy_backoff() {
    return {std::chrono::milliseconds(100), std::chrono::seconds(10)};
}

/// Counts failures in a row; after `attempts` of them the device (or the request) counts as not answering and
/// is probed with an exponential back-off. Used for a device and for a single request.
class Health {
public:
    /// @param attempts  failures in a row after which it counts as not answering, at least 1
    /// @param backoff  between the probes
    explicit Health(std::uint16_t attempts, const Backoff& backoff = probe_backoff())
        : attempts_(std::max<std::uint16_t>(attempts, 1)), backoff_(backoff) {}

    /// A response was received, possibly an exception. @returns whether it did not answer before
    bool answered();

    /// A transmission had no good response. @returns whether it counts as not answering from now on
    bool failed(Instant t);

    /// Failures in a row, at most `attempts`.
    [[nodiscard]] std::uint16_t failures() const { return failures_; }

    [[nodiscard]] bool answering() const { return failures_ < attempts_; }

    /// While not answering: when the next probe may be sent, and the back-off before it.
    [[nodiscard]] Instant probe_at() const { return probe_at_; }
    [[nodiscard]] Duration probe_wait() const { return probe_wait_; }

    /// While not answering: when a probe may be sent before its back-off has passed, because no other request
    /// needs the line. At most one is sent per period; without a period the first back-off takes its place.
    /// @param last    start of the last read of the device
    /// @param period  of the read that probes; zero: none
    /// @returns nothing: the back-off is as short
    [[nodiscard]] std::optional<Instant> early_probe_at(Instant last, Duration period) const;
    /// A read is sent; while not answering it is a probe. An early one postpones the next one by its period.
    /// @returns whether it is an early one: its failure does not count
    [[nodiscard]] bool read_started(Instant t, Duration period);

    /// The next probe may be sent from `t` on. @returns false, and does nothing: it answers
    bool probe_now(Instant t);

private:
    [[nodiscard]] Duration probe_period(Duration period) const;

    std::uint16_t attempts_;
    std::uint16_t failures_ = 0;  // not counted beyond attempts_
    Instant probe_at_ = Instant::min();
    Duration probe_wait_{};
    Backoff backoff_;
};

}  // namespace takt::bus
