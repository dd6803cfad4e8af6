// Commands: what the line does with them (CommandQueue).
#include <algorithm>
#include <utility>

#include "run.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

// Commands of a variable with a write trigger pass the bucket of the trigger.
Result<bool> LinePoller::Run::write(Instant t, const value::WriteCommand& command) {
    TAKT_TRY(const std::size_t v, writable(command.slot));
    const auto& device = devices_[variables_[v].device];
    TAKT_TRY(const Written written, as_written(*variables_[v].model, command.value));
    if (commands_.full()) return fail(Code::queue_full, static_cast<std::int64_t>(kMaxCommands));
    PendingCommand pending{.command = command,
                           .variable = v,
                           .device = variables_[v].device,
                           .rounded = written.rounded,
                           .group = write_groups_.on_change(v)};
    pending.command.value = written.value;
    if (!pending.group) {
        TAKT_TRY(pending.alone, single_write_of(*device.model, *variables_[v].model, written));
        const auto by_trigger = write_groups_.by_trigger(v);
        if (by_trigger && write_groups_.bucket(*by_trigger)) pending.alone.bucket_of = by_trigger;
    }
    if (!reachable(device)) {
        const Reason reason = device.health.unreachable(link_.no_link());
        statuses_.show_unavailable(t, v, reason);
        commands_.refuse(t, command, written.rounded, reason);
        return written.rounded;
    }
    pending.before = written_values_.wanted(v);
    pending.want = written_values_.want(v, written);
    if (pending.group) write_groups_.ask(t, *pending.group);
    pending.order = arrivals_.next();
    commands_.add(t, std::move(pending));
    return written.rounded;
}

void LinePoller::Run::on_command_written(const bus::Outcome& outcome, std::uint64_t order) {
    const std::size_t index = commands_.at(order).device;
    const OutcomeClass outcome_class = note_outcome(outcome, index, nullptr);  // may drop other commands
    auto& command = commands_.at(order);
    if (command.progress.phase() == WritePhase::verifying)
        return on_command_read_back(outcome, outcome_class, order);
    const bool reading_old = command.progress.phase() == WritePhase::reading_old;
    command.progress.transaction_ended();
    const Instant t = outcome.ended_at;
    if (outcome_class.reason != Reason::link_lost)
        statuses_.write_ended(t, command.variable, outcome_class.reason);
    if (reading_old) {
        if (!take_register(outcome, outcome_class,
                           {JobKind::command, order, index, written_shape(command.alone.function)}))
            settle_command(t, order, unwritten(outcome_class), classify_unwritten(outcome_class));
        return;
    }
    const WriteResult what =
        classify_write(outcome, outcome_class, variables_[command.variable].model->safe_to_repeat);
    command.execution = std::max(command.execution, execution(outcome, what));
    if (what.result != CommandResult::done || !command.alone.verify)
        return settle_command(t, order, outcome_class, what);
    command.progress.verify();
    command.alone.verify->begin(order);
    devices_[index].writing = true;
    if (!reachable(devices_[index])) drop_read_backs(t, index, Reason::switched_off);
}

void LinePoller::Run::settle_command(Instant t, std::uint64_t order, const OutcomeClass& outcome_class,
                                     const WriteResult& what) {
    const auto& command = commands_.at(order);
    const auto& device = devices_[command.device];
    if (what.again && reachable(device) && commands_.retry(t, order, outcome_class, device.model->attempts))
        return;
    if (what.result == CommandResult::done) show_written(t, command.variable, command.command.value);
    commands_.finish(t, order, what.result, outcome_class.reason);
}

void LinePoller::Run::drop_pending(Instant t, std::size_t index, Reason reason) {
    drop_read_backs(t, index, reason);
    commands_.drop_waiting(t, index, reason);
    for (const auto r : devices_[index].requests) {
        if (requests_[r].read) reads_.drop_trigger(r);
        if (write_groups_.has(r)) write_groups_.drop_trigger(r);
    }
}

}  // namespace takt::poll
