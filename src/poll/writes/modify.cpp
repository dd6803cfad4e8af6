// Read-modify-writes: nothing is sent between the read and the write (ModifySequence).
#include "line/run.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

// @returns whether the write follows; else nothing was written
bool LinePoller::Run::take_register(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                    const WriteJob& write) {
    if (outcome_class.reason != Reason::ok || !reachable(devices_[write.device()])) {
        modify_.end();
        return false;
    }
    modify_.take_register({kind_of(write.id()), write.index(), write.device(),
                           written_shape(write.function()), outcome.response.registers()[0]});
    return true;
}

void LinePoller::Run::continue_modify(Instant t) {
    const auto step = *modify_.second_step();
    const auto& device = devices_[step.device];
    if (!reachable(device)) {
        abandon(t, device.health.unreachable(link_.no_link()), false);
        return arbiter_.wake_at(t);
    }
    const Instant start = engine_.earliest_start(device.model->address, step.shape);
    if (start > t) return arbiter_.wake_at(start);
    auto write = write_job(transaction_id(step.kind, step.index));
    const auto prepared = write.second_step(t, step.old);
    if (!prepared) {
        abandon(t, Reason::ok, false);
        return arbiter_.wake_at(t);
    }
    modify_.finish();
    write.second_step_submitted();
    submit(t, step.device, write.id(), Purpose::write, *prepared);
}

// Nothing was written yet.
void LinePoller::Run::abandon(Instant t, Reason reason, bool again) {
    const auto step = modify_.finish();
    auto write = write_job(transaction_id(step.kind, step.index));
    if (again)
        write.requeue(t);
    else
        finish_write(t, write, CommandResult::refused, reason);
}

}  // namespace takt::poll
