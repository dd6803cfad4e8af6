// Commands: written with their group or alone, and their outcomes.
#include <algorithm>
#include <utility>

#include "run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

Result<bool> LinePoller::Run::write(Instant t, const value::WriteCommand& command) {
    TAKT_TRY(const std::size_t v, writable(command.slot));
    auto& variable = *variables_[v].written;
    TAKT_TRY(const Written written, as_written(*variables_[v].model, command.value));
    if (commands_.size() + outcomes_.size() >= kMaxCommands)
        return fail(Code::queue_full, static_cast<std::int64_t>(kMaxCommands));
    PendingCommand pending{.command = command, .variable = v, .rounded = written.rounded};
    pending.command.value = written.value;
    if (!variable.change_group) {
        const auto prepared = prepare_alone(pending, written);
        if (!prepared) return std::unexpected(prepared.error());
    }
    const auto& device = devices_[variables_[v].device];
    if (!reachable(device)) {
        const Reason reason = unreachable(device);
        show_unavailable(t, v, reason);
        outcomes_.push_back({command.id, command.slot, CommandResult::refused, reason, written.rounded, t});
        return written.rounded;
    }
    pending.wanted_before = store_[command.slot].wanted;
    pending.want_before = std::exchange(variable.want, ++last_want_);
    pending.want = variable.want;
    note_wanted(v, written);
    pending.group = variable.change_group;
    if (pending.group) {
        ask_group(t, *pending.group);
        ++requests_[*pending.group].write->commands;
    }
    pending.order = ++last_order_;
    commands_.push_back(std::move(pending));
    supersede(t, v, written.value);
    return written.rounded;
}

// A bit of a register is written with 0x16 or by read-modify-write, as the device supports. Commands of a
// variable with a write trigger pass the bucket of the trigger.
Result<void> LinePoller::Run::prepare_alone(PendingCommand& pending, const Written& written) {
    const auto& variable = variables_[pending.variable];
    const auto& model = *variable.model;
    const auto& device = *devices_[variable.device].model;
    wire::Request request;
    pending.function = plan::command_function(device, model);
    if (!is_register_bit(model)) {
        WrittenItems items(pending.function);
        TAKT_CHECK(items.add(model, written.words));
        TAKT_TRY(request, items.request());
    } else if (device.fc22) {
        pending.bits.add(model, written.words);
        request = mask_request(DataAddress{model.start()}, pending.bits);
    } else if (device.read_modify_write) {
        pending.modifies = true;
        pending.bits.add(model, written.words);
        request = wire::ReadRequest{wire::Function::read_holding_registers, DataAddress{model.start()}, 1};
    } else {
        return fail(Code::unsupported, model.name);
    }
    TAKT_TRY(pending.request, wire::prepare(request));
    if (model.verify) pending.verify = std::make_unique<ReadBack>(read_back_of(model));
    const auto by_trigger = variable.written->trigger_group;
    if (by_trigger && requests_[*by_trigger].write->event.bucket) pending.bucket_of = by_trigger;
    return {};
}

PendingCommand& LinePoller::Run::command_of(std::uint64_t order) {
    const auto found = std::ranges::find(commands_, order, &PendingCommand::order);
    TAKT_ASSERT(found != commands_.end());
    return *found;
}

void LinePoller::Run::on_command_written(const bus::Outcome& outcome, std::uint64_t order) {
    const auto& variable = variables_[command_of(order).variable];
    const OutcomeClass outcome_class =
        note_outcome(outcome, variable.device, nullptr);  // may drop other commands
    auto& command = command_of(order);
    if (command.verify && command.verify->in_flight)
        return on_command_read_back(outcome, outcome_class, order);
    const Instant t = outcome.ended_at;
    if (outcome_class.reason != Reason::link_lost)
        set_variable_status(t, command.variable, outcome_class.reason);
    if (command.modify.reading) {
        const Continuation next{JobKind::command, order, variable.device, written_shape(command.function)};
        if (!take_register(outcome, outcome_class, next, command.modify))
            settle_command(t, order, unwritten(outcome_class), classify_unwritten(outcome_class));
        return;
    }
    command.sent = command.sent || outcome.sent;
    const WriteResult what = classify_write(outcome, outcome_class, variable.model->safe_to_repeat);
    command.maybe_done = command.maybe_done || what.result == CommandResult::unknown;
    if (what.result != CommandResult::done || !command.verify)
        return settle_command(t, order, outcome_class, what);
    await_read_back(variable.device, *command.verify, order);
    if (!reachable(devices_[variable.device])) drop_read_backs(t, variable.device, Reason::switched_off);
}

void LinePoller::Run::settle_command(Instant t, std::uint64_t order, const OutcomeClass& outcome_class,
                                     const WriteResult& what) {
    auto& command = command_of(order);
    const auto& device = devices_[variables_[command.variable].device];
    if (what.again && may_repeat(device, outcome_class, command.failures)) {
        if (outcome_class.busy) command.not_before = after(t, command.busy.next());
        command.in_flight = false;
        return;
    }
    if (what.result == CommandResult::done) show_written(t, command.variable, command.command.value);
    finish(t, command, what.result, outcome_class.reason);
    std::erase_if(commands_, [order](const auto& c) { return c.order == order; });
}

// Restores the value wanted before a command that was not executed, unless another value was set since. Later
// commands must not restore the value of this one.
void LinePoller::Run::forget_wanted(const PendingCommand& command) {
    auto& variable = *variables_[command.variable].written;
    for (auto& later : commands_) {
        if (later.variable != command.variable || later.want_before != command.want) continue;
        later.wanted_before = command.wanted_before;
        later.want_before = command.want_before;
    }
    if (variable.want != command.want) return;
    store_.want(command.command.slot, command.wanted_before);
    variable.words.clear();
    variable.want = command.want_before;
}

// A refused last attempt does not prove that earlier ones did not execute; a value read back does.
void LinePoller::Run::finish(Instant t, const PendingCommand& command, CommandResult result, Reason reason) {
    const auto slot = command.command.slot;
    if (result == CommandResult::refused && command.maybe_done && reason != Reason::differs)
        result = CommandResult::unknown;
    if (result == CommandResult::refused || result == CommandResult::expired) forget_wanted(command);
    value::CommandOutcome outcome{command.command.id, slot, result, reason, command.rounded, t};
    if (reason == Reason::differs) {
        outcome.written = command.command.value;
        outcome.read_back = command.read_back;
    }
    outcomes_.push_back(std::move(outcome));
}

void LinePoller::Run::withdraw(Instant t, const PendingCommand& command, CommandResult unsent,
                               Reason reason) {
    if (command.group) --requests_[*command.group].write->commands;
    const bool may_be_sent = command.sent || command.carried;
    finish(t, command, may_be_sent ? CommandResult::unknown : unsent, reason);
}

// A group is written with the latest value of each member: a waiting command with an earlier value is never
// sent. The group keeps its position in the queue.
void LinePoller::Run::supersede(Instant t, std::size_t v, const value::Value& value) {
    const auto goes = [&](const auto& c) {
        return c.variable == v && c.group && !c.in_flight && !value::same(c.command.value, value);
    };
    for (const auto& command : commands_)
        if (goes(command)) withdraw(t, command, CommandResult::refused, Reason::superseded);
    std::erase_if(commands_, goes);
}

void LinePoller::Run::drop_pending(Instant t, std::size_t index, Reason reason) {
    const auto goes = [&](const auto& c) { return !c.in_flight && variables_[c.variable].device == index; };
    drop_read_backs(t, index, reason);
    for (const auto& command : commands_)
        if (goes(command)) withdraw(t, command, CommandResult::refused, reason);
    std::erase_if(commands_, goes);
    for (const auto r : devices_[index].requests) {
        if (requests_[r].read) requests_[r].read->triggered = false;
        if (requests_[r].write) requests_[r].write->triggered = false;
    }
}

void LinePoller::Run::expire_commands(Instant t) {
    const auto goes = [t](const auto& c) { return !c.in_flight && c.command.expires <= t; };
    for (const auto& command : commands_)
        if (goes(command)) withdraw(t, command, CommandResult::expired, Reason::ok);
    std::erase_if(commands_, goes);
}

}  // namespace takt::poll
