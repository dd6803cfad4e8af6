// Writing: with the group, alone, and what becomes of commands.
#include <algorithm>
#include <utility>

#include "run.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

Result<std::size_t> LinePoller::Run::writable(value::SlotId slot) const {
    const std::size_t v = slot.value - first_slot_;
    if (slot.value < first_slot_ || v >= variables_.size()) return fail(Code::not_found);
    const auto& variable = *variables_[v].model;
    if (!variable.write || !variable.used) return fail(Code::not_writable, variable.name);
    return v;
}

const value::Value* LinePoller::Run::value_to_write(std::size_t v) const {
    const auto& wanted = store_[variables_[v].slot].wanted;
    if (!value::is_empty(wanted)) return &wanted;
    return value::is_empty(variables_[v].last_read) ? nullptr : &variables_[v].last_read;
}

Result<bool> LinePoller::Run::set(Instant, value::SlotId slot, const value::Value& value) {
    TAKT_TRY(const std::size_t v, writable(slot));
    TAKT_TRY(const Written written, as_written(*variables_[v].model, value));
    store_.want(slot, written.value);
    if (const auto group = variables_[v].change_group) {
        ask_group(*group);
        requests_[*group].write->asked = true;
    }
    return written.rounded;
}

Result<bool> LinePoller::Run::write(Instant t, const value::WriteCommand& command) {
    TAKT_TRY(const std::size_t v, writable(command.slot));
    const auto& variable = variables_[v];
    TAKT_TRY(const Written written, as_written(*variable.model, command.value));
    if (commands_.size() + outcomes_.size() >= kMaxCommands)
        return fail(Code::queue_full, static_cast<std::int64_t>(kMaxCommands));
    PendingCommand pending{.command = command, .variable = v, .rounded = written.rounded};
    pending.command.value = written.value;
    if (!variable.change_group) {
        const Member member{variable.model, &written.value};
        TAKT_TRY(const wire::Request request, write_request(*variable.model->write, {&member, 1}));
        TAKT_TRY(pending.pdu, wire::encode(request));
        pending.shape = bus::answer_shape(pending.pdu.span());
    }
    const auto& device = devices_[variable.device];
    if (!reachable(device)) {
        const Reason reason = device.enabled ? Reason::not_answering : Reason::switched_off;
        outcomes_.push_back({command.id, command.slot, CommandResult::refused, reason, written.rounded, t});
        return written.rounded;
    }
    pending.wanted_before = store_[command.slot].wanted;
    store_.want(command.slot, written.value);
    pending.group = variable.change_group;
    if (pending.group) {
        ask_group(*pending.group);
        ++requests_[*pending.group].write->commands;
    }
    pending.order = ++last_order_;
    commands_.push_back(std::move(pending));
    return written.rounded;
}

void LinePoller::Run::ask_group(std::size_t request) {
    auto& write = *requests_[request].write;
    if (write.due()) return;
    write.order = ++last_order_;
    write.told_waiting = false;
}

bool LinePoller::Run::group_ready(Instant t, std::size_t index) {
    auto& request = requests_[index];
    for (std::size_t i = 0; i < request.variables.size(); ++i) {
        if (value_to_write(request.variables[i])) continue;
        if (!request.write->told_waiting && observer_)
            observer_->on_write_waiting(t, plan_.line, index, request.plan->variables[i]);
        request.write->told_waiting = true;
        return false;
    }
    return true;
}

Result<wire::Pdu> LinePoller::Run::group_pdu(const RequestRun& request) {
    members_.clear();
    for (const auto v : request.variables) members_.push_back({variables_[v].model, value_to_write(v)});
    TAKT_TRY(const wire::Request write, write_request(request.write->function, members_));
    return wire::encode(write);
}

bool LinePoller::Run::repeatable(std::span<const std::size_t> variables) const {
    return std::all_of(variables.begin(), variables.end(),
                       [&](auto v) { return variables_[v].model->safe_to_repeat; });
}

// Busy (6) is a promise that nothing was done; acknowledge (5), that it will be. What was never sent may
// always be sent. All other failures leave open what happened.
LinePoller::Run::WriteVerdict LinePoller::Run::judge_write(const bus::Outcome& outcome,
                                                           const Verdict& verdict, bool safe_to_repeat) {
    if (verdict.reason == Reason::ok) return {CommandResult::done};
    const bool busy = verdict.busy &&
                      outcome.exception == static_cast<std::uint8_t>(wire::ExceptionCode::server_device_busy);
    if (!outcome.sent || busy) return {CommandResult::refused, true};
    if (verdict.answered && !verdict.busy) return {CommandResult::refused};
    return {CommandResult::unknown, safe_to_repeat && !verdict.answered};
}

// A link that went away is not the device's failure, and does not use up its attempts.
bool LinePoller::Run::may_repeat(const DeviceRun& device, const Verdict& verdict,
                                 std::uint16_t& failures) const {
    if (!reachable(device)) return false;
    return verdict.reason == Reason::link_lost || ++failures < device.model->attempts;
}

void LinePoller::Run::on_group_written(const bus::Outcome& outcome, std::size_t index) {
    auto& request = requests_[index];
    auto& write = *request.write;
    const auto& device = devices_[request.device];
    const Verdict verdict = judge(outcome, request.device, &request.statistics.counters);
    const Instant t = outcome.ended_at;
    if (reachable(device) && verdict.reason != Reason::link_lost) set_status(t, request, verdict.reason);
    for (auto& command : commands_)
        if (command.group == index && command.in_flight) command.sent = command.sent || outcome.sent;
    const auto [result, again] = judge_write(outcome, verdict, repeatable(request.variables));
    if (again && may_repeat(device, verdict, write.failures)) {
        if (verdict.busy) write.not_before = after(t, write.busy.next());
        ask_group(index);
        write.asked = true;
        for (auto& command : commands_)
            if (command.group == index && std::exchange(command.in_flight, false)) ++write.commands;
        return;
    }
    if (result == CommandResult::done)
        for (const auto v : request.variables) show_written(t, v, *value_to_write(v));
    finish_group(t, index, result, verdict.reason);
}

void LinePoller::Run::finish_group(Instant t, std::size_t index, CommandResult result, Reason reason) {
    auto& write = *requests_[index].write;
    write.failures = 0;
    write.busy.reset();
    write.not_before = Instant::min();
    const auto goes = [&](const auto& command) { return command.group == index && command.in_flight; };
    for (const auto& command : commands_)
        if (goes(command)) finish(t, command, result, reason);
    std::erase_if(commands_, goes);
}

void LinePoller::Run::on_command_written(const bus::Outcome& outcome, std::uint64_t order) {
    const auto found = [order](const auto& c) { return c.order == order; };
    auto& command = *std::find_if(commands_.begin(), commands_.end(), found);
    const auto& variable = variables_[command.variable];
    const auto& device = devices_[variable.device];
    const Verdict verdict = judge(outcome, variable.device, nullptr);
    const Instant t = outcome.ended_at;
    command.sent = command.sent || outcome.sent;
    const auto [result, again] = judge_write(outcome, verdict, variable.model->safe_to_repeat);
    if (again && may_repeat(device, verdict, command.failures)) {
        if (verdict.busy) command.not_before = after(t, command.busy.next());
        command.in_flight = false;
        return;
    }
    if (result == CommandResult::done) show_written(t, command.variable, command.command.value);
    finish(t, command, result, verdict.reason);
    std::erase_if(commands_, found);
}

// What cannot be read shows what was last written.
void LinePoller::Run::show_written(Instant t, std::size_t v, const value::Value& value) {
    if (variables_[v].model->read) return;
    const value::Update update{variables_[v].slot, value};
    store_.apply(t, {&update, 1});
}

// What was not done is no longer wanted, unless something else was wanted since.
void LinePoller::Run::finish(Instant t, const PendingCommand& command, CommandResult result, Reason reason) {
    const auto slot = command.command.slot;
    const bool not_done = result == CommandResult::refused || result == CommandResult::expired;
    if (not_done && value::same(store_[slot].wanted, command.command.value))
        store_.want(slot, command.wanted_before);
    outcomes_.push_back({command.command.id, slot, result, reason, command.rounded, t});
}

void LinePoller::Run::withdraw(Instant t, const PendingCommand& command, CommandResult unsent,
                               Reason reason) {
    if (command.group) --requests_[*command.group].write->commands;
    finish(t, command, command.sent ? CommandResult::unknown : unsent, reason);
}

void LinePoller::Run::drop_pending(Instant t, std::size_t index, Reason reason) {
    const auto goes = [&](const auto& c) { return !c.in_flight && variables_[c.variable].device == index; };
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
