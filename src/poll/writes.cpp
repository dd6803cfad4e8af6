// Writes of groups.
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

std::size_t LinePoller::Run::index_in_device(std::size_t v) const {
    return static_cast<std::size_t>(variables_[v].model -
                                    devices_[variables_[v].device].model->variables.data());
}

// The value last set, else last read, else the initial one; nullptr: there is none of them.
const value::Value* LinePoller::Run::value_to_write(std::size_t v) const {
    const auto& wanted = store_[variables_[v].slot].wanted;
    if (!value::is_empty(wanted)) return &wanted;
    const auto& written = *variables_[v].written;
    const auto& held = value::is_empty(written.last_read) ? written.initial : written.last_read;
    return value::is_empty(held) ? nullptr : &held;
}

Result<Written> LinePoller::Run::written_of(std::size_t v) const {
    const auto& variable = *variables_[v].written;
    const auto& value = *value_to_write(v);
    if (variable.words.empty()) return as_written(*variables_[v].model, value);
    Written written{.value = value};
    written.words.assign(variable.words);
    return written;
}

void LinePoller::Run::note_wanted(std::size_t v, const Written& written) {
    store_.want(variables_[v].slot, written.value);
    variables_[v].written->words.assign(written.words.begin(), written.words.end());
}

// Variables that are not read show what was sent; verified ones are compared with it.
void LinePoller::Run::note_sent(std::size_t v, const value::Value& value) {
    const auto& variable = variables_[v];
    if (!variable.model->read || variable.model->verify) variable.written->sent = value;
}

Result<bool> LinePoller::Run::set(Instant t, value::SlotId slot, const value::Value& value) {
    TAKT_TRY(const std::size_t v, writable(slot));
    TAKT_TRY(const Written written, as_written(*variables_[v].model, value));
    note_wanted(v, written);
    auto& variable = *variables_[v].written;
    variable.want = ++last_want_;
    if (const auto group = variable.change_group) {
        variable.pending = true;
        ask_group(t, *group);
        requests_[*group].write->asked = true;
    }
    supersede(t, v, written.value);
    return written.rounded;
}

void LinePoller::Run::ask_group(Instant t, std::size_t request) {
    auto& write = *requests_[request].write;
    if (write.due()) return;
    write.reported_waiting = false;
    write.failures = 0;
    write.event.arrive(t, ++last_order_);
}

// Every member needs a value, except for bits of a register: their neighbours are kept.
bool LinePoller::Run::group_ready(Instant t, std::size_t index) {
    auto& write = *requests_[index].write;
    std::optional<std::size_t> missing;
    if (write.writes_bits()) {
        if (bits_to_write(write).empty()) missing = write.members.front();
    } else {
        const auto found =
            std::ranges::find_if(write.members, [this](std::size_t v) { return !value_to_write(v); });
        if (found != write.members.end()) missing = *found;
    }
    if (!missing) return true;
    if (!write.reported_waiting && observer_)
        observer_->on_write_waiting(t, plan_->line, index, index_in_device(*missing));
    write.reported_waiting = true;
    return false;
}

Result<wire::Request> LinePoller::Run::group_request(const RequestRun& request) {
    const auto& write = *request.write;
    if (write.kind == WriteKind::modify)
        return wire::ReadRequest{wire::Function::read_holding_registers, DataAddress{request.plan->start},
                                 request.plan->quantity};
    if (write.kind == WriteKind::mask) {
        TAKT_TRY(const RegisterBits bits, bits_of(write.sending));
        return mask_request(DataAddress{request.plan->start}, bits);
    }
    WrittenItems items(write.function);
    for (const auto v : write.members) {
        TAKT_TRY(const Written written, written_of(v));
        TAKT_CHECK(items.add(*variables_[v].model, written.words));
        note_sent(v, written.value);
    }
    return write.kind == WriteKind::exchange ? items.exchange(*request.plan) : items.request();
}

bool LinePoller::Run::repeatable(std::span<const std::size_t> variables) const {
    return std::all_of(variables.begin(), variables.end(),
                       [&](auto v) { return variables_[v].model->safe_to_repeat; });
}

// A lost link is no failure of the device: it does not use up its attempts.
bool LinePoller::Run::may_repeat(const DeviceRun& device, const OutcomeClass& outcome_class,
                                 std::uint16_t& failures) const {
    if (!reachable(device)) return false;
    return outcome_class.reason == Reason::link_lost || ++failures < device.model->attempts;
}

// Bits that are not sent keep their status.
void LinePoller::Run::set_write_status(Instant t, RequestRun& request, Reason reason) {
    const auto& write = *request.write;
    for (const auto v : write.writes_bits() ? write.sending : request.variables)
        set_variable_status(t, v, reason);
    if (!reachable(devices_[request.device])) return;
    request.last_reason = reason;
    set_device_status(t, request.device);
}

void LinePoller::Run::on_group_written(const bus::Outcome& outcome, std::size_t index) {
    auto& request = requests_[index];
    auto& write = *request.write;
    const auto& device = devices_[request.device];
    write.in_flight = false;
    if (write.read_back && write.read_back->in_flight) return on_group_read_back(outcome, index);
    note_carried(request.device, outcome.sent && !write.modify.reading);
    const OutcomeClass outcome_class = note_outcome(outcome, request.device, &request.counters);
    const Instant t = outcome.ended_at;
    if (outcome_class.reason != Reason::link_lost) set_write_status(t, request, outcome_class.reason);
    if (write.modify.reading) {
        const Continuation next{JobKind::group_write, index, request.device, written_shape(write.function)};
        if (!take_register(outcome, outcome_class, next, write.modify))
            settle_group(t, index, unwritten(outcome_class), classify_unwritten(outcome_class));
        return;
    }
    for (auto& command : commands_)
        if (command.group == index && command.in_flight) command.sent = command.sent || outcome.sent;
    if (write.kind == WriteKind::exchange && request.read && reachable(device))
        on_exchanged(outcome, outcome_class, request);
    const WriteResult what = classify_write(outcome, outcome_class, repeatable(write.members));
    for (auto& command : commands_)
        if (command.group == index && command.in_flight)
            command.maybe_done = command.maybe_done || what.result == CommandResult::unknown;
    if (what.result != CommandResult::done || !write.read_back)
        return settle_group(t, index, outcome_class, what);
    await_read_back(request.device, *write.read_back, write.read_back->order);
    if (!reachable(device)) drop_read_backs(t, request.device, Reason::switched_off);
}

// Commands of their own whose value a group has written.
void LinePoller::Run::note_carried(std::size_t device, bool sent) {
    for (auto& command : commands_) {
        if (variables_[command.variable].device != device || !std::exchange(command.carried, false)) continue;
        command.sent = command.sent || sent;
        command.maybe_done = command.maybe_done || sent;
    }
}

void LinePoller::Run::settle_group(Instant t, std::size_t index, const OutcomeClass& outcome_class,
                                   const WriteResult& what) {
    auto& write = *requests_[index].write;
    if (what.again && may_repeat(devices_[requests_[index].device], outcome_class, write.failures)) {
        if (outcome_class.busy) write.not_before = after(t, write.busy.next());
        queue_again(t, index);
        return;
    }
    if (what.result == CommandResult::done)
        for (const auto v : write.writes_bits() ? write.sending : write.members)
            show_written(t, v, variables_[v].written->sent);
    finish_group(t, index, what.result, outcome_class.reason);
}

void LinePoller::Run::refuse_outdated(Instant t, std::size_t index) {
    const auto outdated = [&](const auto& c) {
        return c.group == index && c.in_flight &&
               !value::same(c.command.value, store_[c.command.slot].wanted);
    };
    for (const auto& command : commands_) {
        if (!outdated(command)) continue;
        if (command.confirmed)
            finish(t, command, CommandResult::done, Reason::ok);
        else
            finish(t, command, CommandResult::refused, Reason::superseded);
    }
    std::erase_if(commands_, outdated);
}

// A retry needs no new admission. Commands whose variable was set to another value meanwhile end as
// superseded. If only commands wanted the write and none is left, it is not sent.
void LinePoller::Run::queue_again(Instant t, std::size_t index) {
    auto& write = *requests_[index].write;
    if (!write.due()) write.event.order = ++last_order_;
    write.asked = write.asked || write.sent_asked;
    write.event.admitted = true;
    for (const auto v : write.sending) {
        auto& bit = *variables_[v].written;
        bit.pending = bit.pending || bit.sent_pending;
    }
    refuse_outdated(t, index);
    for (auto& command : commands_)
        if (command.group == index && std::exchange(command.in_flight, false)) ++write.commands;
}

void LinePoller::Run::report_group_settled(Instant t, std::size_t index, CommandResult result,
                                           Reason reason) {
    auto& write = *requests_[index].write;
    const auto before = std::exchange(write.settled_want, write.sent_want);
    if (!observer_) return;
    const auto& members = write.writes_bits() ? write.sending : write.members;
    const auto has_command = [&](std::size_t v) {
        return std::ranges::any_of(
            commands_, [&](const auto& c) { return c.group == index && c.in_flight && c.variable == v; });
    };
    const bool any_set =
        std::ranges::any_of(members, [&](auto v) { return variables_[v].written->want > before; });
    settled_variables_.clear();
    for (const auto v : members) {
        const auto want = variables_[v].written->want;
        const bool asked = !any_set || (want > before && want <= write.sent_want);
        if (asked && !has_command(v)) settled_variables_.push_back(index_in_device(v));
    }
    if (!settled_variables_.empty())
        observer_->on_group_settled(
            t, {plan_->line, requests_[index].device, settled_variables_, result, reason,
                write.sent_triggered ? requests_[index].plan->write_trigger : std::nullopt});
}

void LinePoller::Run::finish_group(Instant t, std::size_t index, CommandResult result, Reason reason) {
    report_group_settled(t, index, result, reason);
    auto& write = *requests_[index].write;
    write.failures = 0;
    write.started = write.sent_triggered = false;
    write.busy.reset();
    write.not_before = Instant::min();
    write.sending.clear();
    const auto goes = [&](const auto& command) { return command.group == index && command.in_flight; };
    for (const auto& command : commands_) {
        if (!goes(command)) continue;
        // Members that read back equal are done, though the group differs.
        const bool kept = reason == Reason::differs && value::is_empty(command.read_back);
        finish(t, command, kept ? CommandResult::done : result, kept ? Reason::ok : reason);
    }
    std::erase_if(commands_, goes);
}

// A variable that is not read shows the value last written.
void LinePoller::Run::show_written(Instant t, std::size_t v, const value::Value& value) {
    if (variables_[v].model->read) return;
    const value::Update update{variables_[v].slot, value};
    store_.apply(t, {&update, 1});
}

}  // namespace takt::poll
