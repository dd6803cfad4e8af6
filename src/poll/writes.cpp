// Writes of groups: what the line does with them (WriteGroups).
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

Result<bool> LinePoller::Run::set(Instant t, value::SlotId slot, const value::Value& value) {
    TAKT_TRY(const std::size_t v, writable(slot));
    TAKT_TRY(const Written written, as_written(*variables_[v].model, value));
    written_values_.want(v, written);
    write_groups_.set(t, v);
    commands_.supersede(t, v, written.value);
    return written.rounded;
}

bool LinePoller::Run::group_ready(Instant t, std::size_t index) {
    if (write_groups_.ready(index)) return true;
    const auto missing = write_groups_.report_missing(index);
    if (missing && observer_) observer_->on_write_waiting(t, plan_->line, index, index_in_device(*missing));
    return false;
}

// Bits that are not sent keep their status.
void LinePoller::Run::set_write_status(Instant t, std::size_t index, Reason reason) {
    const auto& write = write_groups_[index];
    if (write.writes_bits())
        statuses_.write_ended(t, index, write.written(), reason);
    else
        statuses_.write_ended(t, index, requests_[index].variables, reason);
}

void LinePoller::Run::on_group_written(const bus::Outcome& outcome, std::size_t index) {
    auto& request = requests_[index];
    const auto& write = write_groups_[index];
    auto& device = devices_[request.device];
    if (write.progress.phase() == WritePhase::verifying) return on_group_read_back(outcome, index);
    const bool reading_old = write.progress.phase() == WritePhase::reading_old;
    commands_.end_carry(request.device, outcome.sent && !reading_old);
    const OutcomeClass outcome_class = note_outcome(outcome, request.device, &request.counters);
    const Instant t = outcome.ended_at;
    write_groups_.transaction_ended(index);
    if (outcome_class.reason != Reason::link_lost) set_write_status(t, index, outcome_class.reason);
    if (reading_old) {
        if (!take_register(outcome, outcome_class,
                           {JobKind::group_write, index, request.device, written_shape(write.function)}))
            settle_group(t, index, unwritten(outcome_class), classify_unwritten(outcome_class));
        return;
    }
    if (write.kind == WriteKind::exchange && request.read && reachable(device))
        on_exchanged(outcome, outcome_class, request);
    const WriteResult what = classify_write(outcome, outcome_class, write_groups_.repeatable(write.members));
    commands_.note_attempt(index, execution(outcome, what));
    if (what.result != CommandResult::done || !write.read_back)
        return settle_group(t, index, outcome_class, what);
    write_groups_.await_read_back(index);
    device.writing = true;
    if (!reachable(device)) drop_read_backs(t, request.device, Reason::switched_off);
}

void LinePoller::Run::settle_group(Instant t, std::size_t index, const OutcomeClass& outcome_class,
                                   const WriteResult& what) {
    const auto& device = devices_[requests_[index].device];
    if (what.again && reachable(device) &&
        write_groups_.retry(t, index, outcome_class, device.model->attempts))
        return;
    if (what.result == CommandResult::done)
        for (const auto v : write_groups_[index].written()) show_written(t, v, written_values_.sent(v));
    finish_group(t, index, what.result, outcome_class.reason);
}

void LinePoller::Run::finish_group(Instant t, std::size_t index, CommandResult result, Reason reason) {
    const auto settled = write_groups_.finish(t, index, result, reason);
    if (!observer_ || settled.variables.empty()) return;
    settled_variables_.clear();
    for (const auto v : settled.variables) settled_variables_.push_back(index_in_device(v));
    observer_->on_group_settled(t,
                                {plan_->line, requests_[index].device, settled_variables_, result, reason,
                                 settled.by_trigger ? requests_[index].plan->write_trigger : std::nullopt});
}

// A variable that is not read shows the value last written.
void LinePoller::Run::show_written(Instant t, std::size_t v, const value::Value& value) {
    if (variables_[v].model->read) return;
    const value::Update update{variables_[v].slot, value};
    store_.apply(t, {&update, 1});
}

}  // namespace takt::poll
