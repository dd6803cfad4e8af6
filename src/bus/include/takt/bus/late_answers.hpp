// Late responses: those that may arrive after their transaction ended (docs/guarantees.md, "Late responses").
#pragma once

#include "takt/base/inplace_vector.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// Decides which requests must wait because a late response could be mistaken for theirs.
///
/// A frame on a serial line does not identify its request. After a failure, the unit is sent only requests
/// whose normal response differs in function or length, until the late response was received or its limit has
/// passed. An exception identifies its function only. If an exception may be a late one, it ends the current
/// transaction, because it may also be its response. From then on the unit is sent no request whose response
/// looks like one of the two until the other one was received or can no longer arrive.
///
/// At most kCapacity late responses are remembered. When there are more, the oldest is dropped and every
/// request waits until its limit.
/// Never allocates; one owner, one thread.
class LateAnswers {
public:
    static constexpr std::size_t kCapacity = 32;

    /// A transaction ended without its response, which may arrive until `until`.
    void expect(UnitId unit, const AnswerShape& shape, Instant until);

    /// An exception ended a transaction of the shape `current` and may have been a late response. Until
    /// `until` the normal response of either may arrive.
    void expect_either(UnitId unit, const AnswerShape& current, Instant until);

    /// Drops the responses that can no longer arrive at `t`.
    void expire(Instant t);

    /// A frame was received that answers no request in flight. @returns whether it was a late response, which
    /// is no longer expected then
    bool settle(UnitId unit, Bytes pdu);

    /// Whether an exception to `function` could be a late one.
    [[nodiscard]] bool ambiguous(UnitId unit, std::uint8_t function) const;

    /// The earliest start of a request with that response; Instant::min() if it need not wait.
    [[nodiscard]] Instant earliest(UnitId unit, const AnswerShape& shape) const;

    void clear();

private:
    struct Expected {
        UnitId unit;
        AnswerShape shape;
        std::size_t other_length = 0;  // of the other response that it may be; that of `shape`: none
        Instant until;
        [[nodiscard]] bool may_be(UnitId of, const AnswerShape& frame) const;
    };
    InplaceVector<Expected, kCapacity> expected_;
    Instant all_wait_until_ = Instant::min();
};

}  // namespace takt::bus
