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
    const auto waits = [v](const auto& command) {
        return command.variable == v && command.group && !command.in_flight;
    };
    return variables_[v].written->pending || std::ranges::any_of(commands_, waits);
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
    if (choose([this](std::size_t v) { return !value::is_empty(store_[variables_[v].slot].wanted); }))
        return bits_;
    choose([this](std::size_t v) { return value_to_write(v) != nullptr; });
    return bits_;
}

Result<RegisterBits> LinePoller::Run::bits_of(std::span<const std::size_t> variables) {
    RegisterBits bits;
    for (const auto v : variables) {
        TAKT_TRY(const Written written, written_of(v));
        bits.add(*variables_[v].model, written.words);
        note_sent(v, written.value);
    }
    return bits;
}

// @returns whether the write follows; else nothing was written
bool LinePoller::Run::take_register(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                    const Continuation& next, Modify& modify) {
    modify.reading = false;
    modifying_ = false;
    if (outcome_class.reason != Reason::ok || !reachable(devices_[next.device])) return false;
    modify.old = outcome.response.registers()[0];
    modifying_ = true;
    continuation_ = next;
    return true;
}

Result<wire::Request> LinePoller::Run::written_back() {
    const auto& next = *continuation_;
    if (next.kind == JobKind::group_write) {
        const auto& request = requests_[next.index];
        TAKT_TRY(const RegisterBits bits, bits_of(request.write->sending));
        return register_request(request.write->function, DataAddress{request.plan->start},
                                bits.in(*request.write->modify.old));
    }
    const auto& command = *std::ranges::find(commands_, next.index, &PendingCommand::order);
    return register_request(command.function, DataAddress{variables_[command.variable].model->start()},
                            command.bits.in(*command.modify.old));
}

void LinePoller::Run::continue_modify(Instant t) {
    const auto& device = devices_[continuation_->device];
    if (!reachable(device)) {
        abandon(t, unreachable(device), false);
        return wake_at(t);
    }
    const Instant start = engine_.earliest_start(device.model->address, continuation_->shape);
    if (start > t) return wake_at(start);
    if (continuation_->kind == JobKind::group_write) {  // something else may have been set since the read
        refuse_outdated(t, continuation_->index);
        note_sending(*requests_[continuation_->index].write);
    }
    const auto write = written_back();
    const auto prepared = write ? wire::prepare(*write) : std::unexpected(write.error());
    if (!prepared) {
        abandon(t, Reason::ok, false);
        return wake_at(t);
    }
    const auto next = *std::exchange(continuation_, std::nullopt);
    modifying_ = false;
    if (next.kind == JobKind::group_write) requests_[next.index].write->in_flight = true;
    submit(t, next.device, transaction_id(next.kind, next.index), Purpose::write, *prepared);
}

// Nothing was written yet.
void LinePoller::Run::abandon(Instant t, Reason reason, bool again) {
    const auto next = *std::exchange(continuation_, std::nullopt);
    modifying_ = false;
    if (next.kind == JobKind::group_write)
        return again ? queue_again(t, next.index)
                     : finish_group(t, next.index, CommandResult::refused, reason);
    auto& command = command_of(next.index);
    if (again) {
        command.in_flight = false;
        return;
    }
    finish(t, command, CommandResult::refused, reason);
    std::erase_if(commands_, [&](const auto& c) { return c.order == next.index; });
}

}  // namespace takt::poll
