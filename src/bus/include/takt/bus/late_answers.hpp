// Answers that may still come after their request was given up (docs/guarantees.md, "Late responses").
#pragma once

#include "takt/base/inplace_vector.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// Which requests must wait because a late answer could be taken for theirs.
///
/// On a serial line nothing in a frame says which request it answers. After a request was given up, its unit
/// is only sent requests whose normal answer differs in function or length, until the late answer was seen or
/// its limit has passed. An exception tells its function only. So an exception that could be a late one ends
/// the transaction it seems to answer, but from then on that unit is sent nothing of that function until the
/// other of the two answers was seen or can no longer come.
///
/// At most kCapacity answers are remembered; beyond, everything waits for the one that would be forgotten.
/// Never allocates; one owner, one thread.
class LateAnswers {
public:
    static constexpr std::size_t kCapacity = 32;

    /// A request was given up at its deadline; its answer may come until `until`.
    void expect(UnitId unit, const AnswerShape& shape, Instant until);

    /// From now on no answer of that function can be told from another, until `until`.
    void expect_any(UnitId unit, std::uint8_t function, Instant until);

    /// Forgets what can no longer come at `t`.
    void expire(Instant t);

    /// A frame came that answers nothing that is waited for. @returns whether it is one of the late answers,
    /// now settled.
    bool settle(UnitId unit, Bytes pdu);

    /// Whether an exception to `function` could be a late one.
    [[nodiscard]] bool ambiguous(UnitId unit, std::uint8_t function) const;

    /// The earliest moment a request with that answer may be sent; Instant::min() when nothing stands against
    /// it.
    [[nodiscard]] Instant earliest(UnitId unit, const AnswerShape& shape) const;

    void clear();

private:
    struct Expected {
        UnitId unit;
        AnswerShape shape;
        Instant until;
    };
    InplaceVector<Expected, kCapacity> expected_;
    Instant all_wait_until_ = Instant::min();
};

}  // namespace takt::bus
