// Whether a device is polled and answers, and when it is probed.
#pragma once

#include <cstdint>
#include <optional>

#include "devices/outcome_class.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/health.hpp"
#include "takt/model/project.hpp"
#include "takt/poll/statistics.hpp"

namespace takt::poll {

/// What the end of a transaction means for its device.
enum class DeviceVerdict : std::uint8_t {
    ignored,   ///< the device is switched off, or its link was lost
    answered,  ///< also with an exception
    returned,  ///< it answered and did not before: restart() must follow
    failed,    ///< it stays as it was
    lost,      ///< it does not answer from now on
};

/// The health of one device: whether it is switched on, whether it answers, and its outages.
///
/// After `attempts` failures in a row it does not answer. It is then probed with a growing back-off. A probe
/// before its back-off has passed (an early one) costs other devices no time: its failure does not change the
/// back-off. A device without reads is not probed. It stays reachable: its writes serve as probes.
///
/// It does not know requests or the line: the caller reports events and acts on the results. Time must not
/// run backwards. One owner, one thread. Never allocates.
class DeviceHealth {
public:
    /// A device of which nothing is known, on a line whose link is down.
    /// @param attempts  failures in a row after which it does not answer
    /// @param backoff   between probes
    /// @param enabled   it is switched on
    DeviceHealth(std::uint16_t attempts, const model::Backoff& backoff, bool enabled);
    DeviceHealth() : DeviceHealth(1, {}, true) {}

    [[nodiscard]] bool enabled() const { return enabled_; }
    /// Also of a device of which nothing is known.
    [[nodiscard]] bool answering() const { return health_.answering(); }
    /// Whether requests other than probes may be sent to it.
    [[nodiscard]] bool reachable() const { return enabled_ && (answering() || !has_reads_); }
    /// Why it is not reachable. @param no_link  the reason while its link is down
    [[nodiscard]] value::Reason unreachable(value::Reason no_link) const;
    /// Failures in a row, at most `attempts`.
    [[nodiscard]] std::uint16_t failures() const { return health_.failures(); }
    [[nodiscard]] const DeviceCondition& condition() const { return condition_; }
    /// The state of a device of which nothing is known.
    [[nodiscard]] DeviceState initial_state(bool link_up) const;
    /// The health of a read of the device that begins anew.
    [[nodiscard]] bus::Health fresh() const;

    /// Whether the plan reads it.
    void set_reads(bool has_reads) { has_reads_ = has_reads; }

    // ---- switch and link

    /// @returns whether it was switched
    bool enable(bool on);
    /// Nothing is known of it any more.
    void restart() { health_ = fresh(); }
    /// @returns whether its state changes
    bool enter(Instant t, DeviceState state);
    /// The state counts for its availability from now on, also the state in which it began.
    void observe(Instant t);
    /// Goes on where the device of another poller is, but keeps its switch.
    /// @returns whether that one was switched the same way
    bool take_over(const DeviceHealth& old);

    // ---- transactions

    /// A transaction has ended. enter() must follow if it was not ignored and the device has another state.
    /// @param others_in_flight  to the device; of several in flight when it failed, only the last one counts
    DeviceVerdict ended(Instant sent_at, Instant t, const OutcomeClass& outcome_class, bool others_in_flight);

    // ---- probes

    /// Its reads are sent as probes.
    [[nodiscard]] bool probed() const { return !answering() && has_reads_; }
    /// While it does not answer: when the next probe may be sent, and the back-off before it.
    [[nodiscard]] Instant probe_at() const { return health_.probe_at(); }
    [[nodiscard]] Duration probe_wait() const { return health_.probe_wait(); }
    /// See bus::Health.
    [[nodiscard]] std::optional<Instant> early_probe_at(Instant last, Duration period) const {
        return health_.early_probe_at(last, period);
    }
    /// The next probe may be sent from `t` on. @returns false, and does nothing: it is not probed
    bool probe_now(Instant t) { return probed() && enabled_ && health_.probe_now(t); }
    /// A read is sent. While the device does not answer, it is a probe.
    void read_started(Instant t, Duration period);
    /// The probe in flight is an early one.
    [[nodiscard]] bool probes_early() const { return probes_early_; }

private:
    std::uint16_t attempts_;
    bool enabled_;
    bool has_reads_ = false;
    bool probes_early_ = false;
    model::Backoff backoff_;
    bus::Health health_;
    Instant failing_since_;  // start of the first of the failed attempts in a row
    DeviceCondition condition_;
};

}  // namespace takt::poll
