// Writes: what the line does with them, of groups and of commands alone (WriteJob).
#include "line/run.hpp"

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

Result<bool> LinePoller::Run::set(Instant t, value::SlotId slot, const value::Value& value) {
    TAKT_TRY(const std::size_t v, writable(slot));
    TAKT_TRY(const Written written, as_written(*variables_[v].model, value));
    written_values_.want(v, written);
    write_groups_.set(t, v);
    if (const auto group = write_groups_.on_change(v)) offers_.note_event(*group);
    commands_.supersede(t, v, written.value);
    return written.rounded;
}

void LinePoller::Run::report_waiting_writes(Instant t) {
    while (const auto waiting = write_groups_.take_waiting())
        if (observer_)
            observer_->on_write_waiting(t, plan_->line, waiting->group, index_in_device(waiting->variable));
}

WriteJob LinePoller::Run::write_job(bus::TransactionId id) {
    const auto index = index_of(id);
    const std::size_t device =
        kind_of(id) == JobKind::group_write ? requests_[index].device : commands_.at(index).device;
    return {{write_groups_, commands_, written_values_}, id, device};
}

// Bits that are not sent keep their status.
void LinePoller::Run::set_write_status(Instant t, const WriteJob& write, Reason reason) {
    if (!write.of_group()) return statuses_.write_ended(t, write.written().front(), reason);
    const bool bits = write_groups_[write.index()].writes_bits();
    const std::span<const std::size_t> all = requests_[write.index()].variables;
    statuses_.write_ended(t, write.index(), bits ? write.written() : all, reason);
}

void LinePoller::Run::on_written(const bus::Outcome& outcome) {
    auto write = write_job(outcome.id);
    const WritePhase phase = write.progress().phase();
    auto* const request = write.of_group() ? &requests_[write.index()] : nullptr;
    if (request && phase != WritePhase::verifying)
        commands_.end_carry(write.device(), outcome.sent && phase == WritePhase::writing);
    const OutcomeClass outcome_class =  // may end other writes of the device
        note_outcome(outcome, write.device(), request);
    write.transaction_ended();
    if (phase == WritePhase::verifying) return on_read_back(outcome, outcome_class, write);
    const Instant t = outcome.ended_at;
    if (outcome_class.reason != Reason::link_lost) set_write_status(t, write, outcome_class.reason);
    if (phase == WritePhase::reading_old) {
        if (!take_register(outcome, outcome_class, write))
            settle_write(t, write, unwritten(outcome_class), classify_unwritten(outcome_class));
        return;
    }
    auto& device = devices_[write.device()];
    if (request && request->read && write_groups_[write.index()].kind == WriteKind::exchange &&
        reachable(device))
        on_exchanged(outcome, outcome_class, write.index());
    const WriteResult what = classify_write(outcome, outcome_class, write.repeatable(write.members()));
    write.note_attempt(execution(outcome, what));
    if (what.result != CommandResult::done || !write.read_back())
        return settle_write(t, write, outcome_class, what);
    write.await_read_back();
    device.writing = true;
    if (!reachable(device)) drop_read_backs(t, write.device(), Reason::switched_off);
}

void LinePoller::Run::settle_write(Instant t, WriteJob write, const OutcomeClass& outcome_class,
                                   const WriteResult& what) {
    const auto& device = devices_[write.device()];
    if (what.again && reachable(device) && write.retry(t, outcome_class, device.model->attempts)) return;
    give_up_held(write.device());  // they were read before it
    if (what.result == CommandResult::done) publisher_.show_written(t, write.written());
    finish_write(t, write, what.result, outcome_class.reason);
}

void LinePoller::Run::finish_write(Instant t, WriteJob write, CommandResult result, Reason reason) {
    const auto settled = write.finish(t, result, reason);
    if (!observer_ || settled.variables.empty()) return;
    settled_variables_.clear();
    for (const auto v : settled.variables) settled_variables_.push_back(index_in_device(v));
    const auto trigger = requests_[write.index()].plan->write_trigger;
    observer_->on_group_settled(t, {plan_->line, write.device(), settled_variables_, result, reason,
                                    settled.by_trigger ? trigger : std::nullopt});
}

}  // namespace takt::poll
