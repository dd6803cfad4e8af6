#include "devices/outcome_class.hpp"

#include "takt/bus/outcome_status.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

bool misdirected(const bus::Outcome& outcome) {
    return outcome.status == bus::Status::timeout && outcome.instead.has_value();
}

OutcomeClass classify(const bus::Outcome& outcome) {
    const auto [status, answered, busy] = bus::status_of(outcome);
    if (outcome.status == bus::Status::closed) return {Reason::closed, answered, busy};
    return {misdirected(outcome) ? Reason::unexpected_reply : Reason{number(status)}, answered, busy};
}

// Exception 6 (busy) means that the write did not execute, 5 (acknowledge) that it will. A write that was not
// sent may be sent. After every other failure it may have executed.
WriteResult classify_write(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                           bool safe_to_repeat) {
    if (outcome_class.reason == Reason::ok) return {CommandResult::done};
    const bool busy = outcome_class.busy &&
                      outcome.exception == static_cast<std::uint8_t>(wire::ExceptionCode::server_device_busy);
    if (!outcome.sent || busy) return {CommandResult::refused, true};
    if (!outcome_class.transient()) return {CommandResult::refused};
    return {CommandResult::unknown, safe_to_repeat && !outcome_class.busy};
}

Execution execution(const bus::Outcome& outcome, const WriteResult& result) {
    if (result.result == CommandResult::unknown) return Execution::possible;
    return outcome.sent ? Execution::sent : Execution::not_sent;
}

OutcomeClass unwritten(const OutcomeClass& outcome_class) {
    OutcomeClass reported = outcome_class;
    if (reported.reason == Reason::ok) reported.reason = Reason::switched_off;
    return reported;
}

WriteResult classify_unwritten(const OutcomeClass& outcome_class) {
    return {CommandResult::refused, outcome_class.reason != Reason::ok && outcome_class.transient()};
}

}  // namespace takt::poll
