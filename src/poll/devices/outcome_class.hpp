// Classes of outcomes: what the poller does next.
#pragma once

#include <cstdint>

#include "takt/bus/outcome_status.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/value/command.hpp"
#include "takt/value/value.hpp"

namespace takt::poll {

/// The class of an outcome: the reason that the user sees, and whether the device answered.
struct OutcomeClass {
    value::Reason reason = value::Reason::ok;
    bool answered = false;  // by the device itself, not by a gateway
    bool busy = false;      // exceptions 5 and 6

    [[nodiscard]] StatusCode status() const { return StatusCode{static_cast<std::uint16_t>(reason)}; }
    /// The same request may get another answer.
    [[nodiscard]] bool transient() const { return bus::OutcomeStatus{status(), answered, busy}.transient(); }
};
[[nodiscard]] OutcomeClass classify(const bus::Outcome& outcome);
/// A response came instead that does not belong to the request.
[[nodiscard]] bool misdirected(const bus::Outcome& outcome);
/// For a read-modify-write whose write is not sent: switched off if the read succeeded, else the class of the
/// read.
[[nodiscard]] OutcomeClass unwritten(const OutcomeClass& outcome_class);

/// The result of a write.
struct WriteResult {
    value::CommandResult result = value::CommandResult::done;
    bool again = false;  // it may be sent again instead
};
[[nodiscard]] WriteResult classify_write(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                         bool safe_to_repeat);
/// How far the attempts of a write that have ended came.
enum class Execution : std::uint8_t {
    not_sent,
    sent,      ///< it was refused or confirmed
    possible,  ///< at least one may have been executed
};
[[nodiscard]] Execution execution(const bus::Outcome& outcome, const WriteResult& result);

/// Of a read-modify-write whose write was not sent.
[[nodiscard]] WriteResult classify_unwritten(const OutcomeClass& outcome_class);

}  // namespace takt::poll
