// Writes of register bits: which bits are written, and the two steps of a read-modify-write. To keep it
// atomic on the line, nothing is sent between its read and its write.
#include <algorithm>
#include <utility>

#include "run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

bool LinePoller::Run::to_be_written(std::size_t v) const {
    return variables_[v].written->pending || commands_.waits_for_group(v);
}

// By a change: the bits set since the last write. By a trigger: all bits ever set; if there are none, the
// bits as read, else with their defaults. Other bits of the group are not written back: that would undo
// changes made elsewhere.
const std::vector<std::size_t>& LinePoller::Run::bits_to_write(const WriteJob& write) {
    const auto choose = [&](auto wanted) {
        bits_.clear();
        for (const auto v : write.members)
            if (wanted(v)) bits_.push_back(v);
        return !bits_.empty();
    };
    if (!write.triggered) {
        choose([this](std::size_t v) { return to_be_written(v); });
        return bits_;
    }
    if (choose([this](std::size_t v) { return written_values_.was_set(v); })) return bits_;
    choose([this](std::size_t v) { return written_values_.to_write(v) != nullptr; });
    return bits_;
}

Result<RegisterBits> LinePoller::Run::bits_of(std::span<const std::size_t> variables) {
    RegisterBits bits;
    for (const auto v : variables) {
        TAKT_TRY(const Written written, written_values_.encoded(v));
        bits.add(*variables_[v].model, written.words);
        written_values_.note_sent(v, written.value);
    }
    return bits;
}

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

Result<wire::Request> LinePoller::Run::written_back(const ModifySequence::SecondStep& next) {
    if (next.kind == JobKind::group_write) {
        const auto& request = requests_[next.index];
        TAKT_TRY(const RegisterBits bits, bits_of(request.write->sending));
        return register_request(request.write->function, DataAddress{request.plan->start}, bits.in(next.old));
    }
    const auto& command = commands_.at(next.index);
    return second_step(command.alone, *variables_[command.variable].model, next.old);
}

void LinePoller::Run::continue_modify(Instant t) {
    const auto step = *modify_.second_step();
    const auto& device = devices_[step.device];
    if (!reachable(device)) {
        abandon(t, unreachable(device), false);
        return wake_at(t);
    }
    const Instant start = engine_.earliest_start(device.model->address, step.shape);
    if (start > t) return wake_at(start);
    if (step.kind == JobKind::group_write) {  // something else may have been set since the read
        commands_.refuse_outdated(t, step.index);
        note_sending(*requests_[step.index].write);
    }
    const auto write = written_back(step);
    const auto prepared = write ? wire::prepare(*write) : std::unexpected(write.error());
    if (!prepared) {
        abandon(t, Reason::ok, false);
        return wake_at(t);
    }
    modify_.finish();
    auto& progress = step.kind == JobKind::group_write ? requests_[step.index].write->progress
                                                       : commands_.at(step.index).progress;
    progress.write();
    submit(t, step.device, transaction_id(step.kind, step.index), Purpose::write, *prepared);
}

// Nothing was written yet.
void LinePoller::Run::abandon(Instant t, Reason reason, bool again) {
    const auto step = modify_.finish();
    if (step.kind == JobKind::group_write)
        return again ? queue_again(t, step.index)
                     : finish_group(t, step.index, CommandResult::refused, reason);
    if (again)
        commands_.at(step.index).progress.end();
    else
        commands_.finish(t, step.index, CommandResult::refused, reason);
}

}  // namespace takt::poll
