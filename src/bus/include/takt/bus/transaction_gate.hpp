// Limits how often a class of transactions goes ahead of polling.
#pragma once

#include <cstdint>

#include "takt/base/time.hpp"

namespace takt::bus {

/// A token bucket that does not fill while a transaction of its class is on the line. With `burst` 1, the
/// next transaction goes ahead no earlier than `interval` after the end of the last one, however long that
/// one took. So the class leaves at least `interval` of the line to others between two of its transactions
/// (docs/guarantees.md, "Tasks of clients").
///
/// A transaction that starts without a token, because the line had nothing else to do, empties the bucket.
///
/// Time is given by the caller and must not run backwards; there is no clock inside. One owner, one thread;
/// copying copies the state. Never allocates.
class TransactionGate {
public:
    /// @param burst     transactions admitted at once, at least 1; fewer if burst * interval exceeds 73 years
    /// @param interval  least mean distance from the end of one to the start of the next, >= 0
    TransactionGate(std::uint32_t burst, Duration interval);

    /// Whether a transaction may start ahead of polling at `t`.
    [[nodiscard]] bool admits(Instant t) const { return next_admission(t) <= t; }

    /// The earliest instant at which admits() is true; `t` itself when a token is there. kNever: a
    /// transaction must end first.
    [[nodiscard]] Instant next_admission(Instant t) const;

    /// A transaction starts, admitted or not.
    void started(Instant t);

    /// A further transaction on behalf of one that was started before: a repetition, or its verification. It
    /// takes no token.
    void resumed(Instant t);

    /// One of them has ended; the line is free at `t`, which may lie in the future.
    void ended(Instant t);

private:
    Duration interval_;
    Duration capacity_;                    // burst, expressed as the time it takes to earn it
    Instant empty_at_ = Instant::min();    // when the bucket would have been empty and started to fill
    Instant stopped_at_ = Instant::min();  // while a transaction is on the line: since when
    std::uint32_t running_ = 0;
};

}  // namespace takt::bus
