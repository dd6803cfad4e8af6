// Classes of outcomes: what the poller does next.
#pragma once

#include "takt/bus/transaction.hpp"
#include "takt/value/command.hpp"
#include "takt/value/value.hpp"

namespace takt::poll {

/// The class of an outcome: the reason that the user sees, and whether the device answered.
struct Verdict {
    value::Reason reason = value::Reason::ok;
    bool answered = false;  // by the device itself, not by a gateway
    bool busy = false;      // exceptions 5 and 6
};
[[nodiscard]] Verdict verdict_of(const bus::Outcome& outcome);
/// For a read-modify-write whose write is not sent: switched off if the read succeeded, else the class of the
/// read.
[[nodiscard]] Verdict unwritten(const Verdict& verdict);

/// The result of a write.
struct WriteVerdict {
    value::CommandResult result = value::CommandResult::done;
    bool again = false;  // it may be sent again instead
};
[[nodiscard]] WriteVerdict judge_write(const bus::Outcome& outcome, const Verdict& verdict,
                                       bool safe_to_repeat);
/// Of a read-modify-write whose write was not sent.
[[nodiscard]] WriteVerdict judge_unwritten(const Verdict& verdict);

}  // namespace takt::poll
