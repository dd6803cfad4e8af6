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

bool LinePoller::Run::write_due(std::size_t request) const {
    const auto& write = *requests_[request].write;
    return write.asked || write.triggered || commands_.waiting(request) > 0;
}

Result<bool> LinePoller::Run::set(Instant t, value::SlotId slot, const value::Value& value) {
    TAKT_TRY(const std::size_t v, writable(slot));
    TAKT_TRY(const Written written, as_written(*variables_[v].model, value));
    written_values_.want(v, written);
    auto& variable = *variables_[v].written;
    if (const auto group = variable.change_group) {
        variable.pending = true;
        ask_group(t, *group);
        requests_[*group].write->asked = true;
    }
    commands_.supersede(t, v, written.value);
    return written.rounded;
}

void LinePoller::Run::ask_group(Instant t, std::size_t request) {
    auto& write = *requests_[request].write;
    if (write_due(request)) return;
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
        const auto found = std::ranges::find_if(
            write.members, [this](std::size_t v) { return !written_values_.to_write(v); });
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
        TAKT_TRY(const Written written, written_values_.encoded(v));
        TAKT_CHECK(items.add(*variables_[v].model, written.words));
        written_values_.note_sent(v, written.value);
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
    if (write.progress.phase() == WritePhase::verifying) return on_group_read_back(outcome, index);
    const bool reading_old = write.progress.phase() == WritePhase::reading_old;
    commands_.end_carry(request.device, outcome.sent && !reading_old);
    const OutcomeClass outcome_class = note_outcome(outcome, request.device, &request.counters);
    const Instant t = outcome.ended_at;
    write.progress.transaction_ended();
    if (outcome_class.reason != Reason::link_lost) set_write_status(t, request, outcome_class.reason);
    if (reading_old) {
        if (!take_register(outcome, outcome_class,
                           {JobKind::group_write, index, request.device, written_shape(write.function)}))
            settle_group(t, index, unwritten(outcome_class), classify_unwritten(outcome_class));
        return;
    }
    if (write.kind == WriteKind::exchange && request.read && reachable(device))
        on_exchanged(outcome, outcome_class, request);
    const WriteResult what = classify_write(outcome, outcome_class, repeatable(write.members));
    commands_.note_attempt(index, execution(outcome, what));
    if (what.result != CommandResult::done || !write.read_back)
        return settle_group(t, index, outcome_class, what);
    await_read_back(request.device, write.progress, *write.read_back, write.read_back->order);
    if (!reachable(device)) drop_read_backs(t, request.device, Reason::switched_off);
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
            show_written(t, v, written_values_.sent(v));
    finish_group(t, index, what.result, outcome_class.reason);
}

// A retry needs no new admission. Commands whose variable was set to another value meanwhile end as
// superseded. If only commands wanted the write and none is left, it is not sent.
void LinePoller::Run::queue_again(Instant t, std::size_t index) {
    auto& write = *requests_[index].write;
    if (!write_due(index)) write.event.order = ++last_order_;
    write.asked = write.asked || write.sent_asked;
    write.event.admitted = true;
    for (const auto v : write.sending) {
        auto& bit = *variables_[v].written;
        bit.pending = bit.pending || bit.sent_pending;
    }
    commands_.requeue_group(t, index);
    write.progress.end();
}

void LinePoller::Run::report_group_settled(Instant t, std::size_t index, CommandResult result,
                                           Reason reason) {
    auto& write = *requests_[index].write;
    const auto before = std::exchange(write.settled_want, write.sent_want);
    if (!observer_) return;
    const auto& members = write.writes_bits() ? write.sending : write.members;
    const bool any_set =
        std::ranges::any_of(members, [&](auto v) { return written_values_.number(v) > before; });
    settled_variables_.clear();
    for (const auto v : members) {
        const auto want = written_values_.number(v);
        const bool asked = !any_set || (want > before && want <= write.sent_want);
        if (asked && !commands_.begun(index, v)) settled_variables_.push_back(index_in_device(v));
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
    write.progress.end();
    commands_.finish_group(t, index, result, reason);
}

// A variable that is not read shows the value last written.
void LinePoller::Run::show_written(Instant t, std::size_t v, const value::Value& value) {
    if (variables_[v].model->read) return;
    const value::Update update{variables_[v].slot, value};
    store_.apply(t, {&update, 1});
}

}  // namespace takt::poll
