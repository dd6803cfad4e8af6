// Read-modify-writes: nothing is sent between the read and the write (ModifySequence).
#include "run.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

// @returns whether the write follows; else nothing was written
bool LinePoller::Run::take_register(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                    ModifySequence::SecondStep next) {
    if (outcome_class.reason != Reason::ok || !reachable(devices_[next.device])) {
        modify_.end();
        return false;
    }
    next.old = outcome.response.registers()[0];
    modify_.take_register(next);
    return true;
}

Result<wire::PreparedRequest> LinePoller::Run::second_request(Instant t,
                                                              const ModifySequence::SecondStep& step) {
    if (step.kind == JobKind::group_write) return write_groups_.modify(t, step.index, step.old);
    const auto& command = commands_.at(step.index);
    return wire::prepare(second_step(command.alone, *variables_[command.variable].model, step.old));
}

void LinePoller::Run::continue_modify(Instant t) {
    const auto step = *modify_.second_step();
    const auto& device = devices_[step.device];
    if (!reachable(device)) {
        abandon(t, device.health.unreachable(link_.no_link()), false);
        return wake_at(t);
    }
    const Instant start = engine_.earliest_start(device.model->address, step.shape);
    if (start > t) return wake_at(start);
    const auto prepared = second_request(t, step);
    if (!prepared) {
        abandon(t, Reason::ok, false);
        return wake_at(t);
    }
    modify_.finish();
    if (step.kind == JobKind::group_write)
        write_groups_.second_step_submitted(step.index);
    else
        commands_.at(step.index).progress.write();
    submit(t, step.device, transaction_id(step.kind, step.index), Purpose::write, *prepared);
}

// Nothing was written yet.
void LinePoller::Run::abandon(Instant t, Reason reason, bool again) {
    const auto step = modify_.finish();
    if (step.kind == JobKind::group_write)
        return again ? write_groups_.requeue(t, step.index)
                     : finish_group(t, step.index, CommandResult::refused, reason);
    if (again)
        commands_.at(step.index).progress.end();
    else
        commands_.finish(t, step.index, CommandResult::refused, reason);
}

}  // namespace takt::poll
