// Classes of outcomes: what the poller does next.
#pragma once

#include <cstdint>

#include "takt/bus/transaction.hpp"
#include "takt/value/command.hpp"
#include "takt/value/value.hpp"

namespace takt::poll {

/// The class of an outcome: the reason that the user sees, and whether the device answered.
struct OutcomeClass {
    value::Reason reason = value::Reason::ok;
    bool answered = false;  // by the device itself, not by a gateway
    bool busy = false;      // exceptions 5 and 6
};
[[nodiscard]] OutcomeClass classify(const bus::Outcome& outcome);
/// For a read-modify-write whose write is not sent: switched off if the read succeeded, else the class of the
/// read.
[[nodiscard]] OutcomeClass unwritten(const OutcomeClass& outcome_class);

/// A failed write is repeated while its device has attempts left. A lost link is no failure of the device: it
/// does not use up its attempts.
/// @param failures  of this write so far; counted
[[nodiscard]] inline bool attempts_left(const OutcomeClass& outcome_class, std::uint16_t attempts,
                                        std::uint16_t& failures) {
    return outcome_class.reason == value::Reason::link_lost || ++failures < attempts;
}

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
