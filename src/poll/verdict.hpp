// How the outcome of a transaction is treated.
#pragma once

#include "takt/bus/transaction.hpp"
#include "takt/value/command.hpp"
#include "takt/value/value.hpp"

namespace takt::poll {

/// How an outcome is treated: what the user is told, and whether it was an answer of the device.
struct Verdict {
    value::Reason reason = value::Reason::ok;
    bool answered = false;  // the device itself said something
    bool busy = false;      // exceptions 5 and 6
};
[[nodiscard]] Verdict verdict_of(const bus::Outcome& outcome);
/// Of the read before a write that does not follow: the device was switched off meanwhile, or what it says.
[[nodiscard]] Verdict unwritten(const Verdict& verdict);

/// What becomes of a write.
struct WriteVerdict {
    value::CommandResult result = value::CommandResult::done;
    bool again = false;  // it may be sent once more instead
};
[[nodiscard]] WriteVerdict judge_write(const bus::Outcome& outcome, const Verdict& verdict,
                                       bool safe_to_repeat);
/// The read before a write failed, or the write does not follow: nothing was written.
[[nodiscard]] WriteVerdict judge_unwritten(const Verdict& verdict);

}  // namespace takt::poll
