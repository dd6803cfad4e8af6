// How long something was available.
#pragma once

#include <algorithm>
#include <optional>

#include "takt/base/time.hpp"

namespace takt::poll {

struct Availability {
    Duration observed{};  ///< zero: nothing is known yet
    Duration downtime{};  ///< part of `observed`
    /// The part of the observed time without downtime, 0..1; nothing: nothing is known yet.
    [[nodiscard]] std::optional<double> share() const {
        if (observed <= Duration::zero()) return std::nullopt;
        return static_cast<double>((observed - downtime).count()) / static_cast<double>(observed.count());
    }
    friend bool operator==(const Availability&, const Availability&) = default;
};

/// Adds up the time in which something was observed and the time in which it was down.
///
/// After begin() it is not known whether it is up or down, until the first up() or down(). That time then
/// counts as the state that was found. Time must not run backwards. Nothing in it allocates.
class AvailabilityMeter {
public:
    /// It is observed from now on. No effect while it is.
    void begin(Instant t) {
        if (!since_) since_ = t;
    }
    /// It is observed no more: it was switched off.
    void pause(Instant t) {
        if (!since_) return;
        before_ = at(t);
        since_.reset();
        down_since_.reset();
        known_ = false;
    }
    void up(Instant t) {
        known_ = true;
        if (down_since_) before_.downtime += t - *down_since_;
        down_since_.reset();
    }
    /// @param since  when it went down, if it is found later
    /// @returns whether this is the begin of an outage
    bool down(Instant since) {
        if (!since_ || down_since_) return false;
        down_since_ = known_ ? std::max(since, *since_) : *since_;
        known_ = true;
        return true;
    }
    /// While it is down: since when.
    [[nodiscard]] std::optional<Instant> down_since() const { return down_since_; }

    /// Until `t`.
    [[nodiscard]] Availability at(Instant t) const {
        Availability now = before_;
        if (since_ && known_) now.observed += std::max(t - *since_, Duration::zero());
        if (down_since_) now.downtime += std::max(t - *down_since_, Duration::zero());
        return now;
    }

private:
    Availability before_;  // of ended observations; the downtime also of the outages that have ended
    std::optional<Instant> since_;
    std::optional<Instant> down_since_;
    bool known_ = false;
};

}  // namespace takt::poll
