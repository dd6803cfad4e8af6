// Verification of writes: a write that the device confirmed is read back and compared.
#include <algorithm>

#include "run.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

void LinePoller::Run::consider_read_back(Instant t, std::size_t index, const ReadBack& back,
                                         Candidate candidate) {
    const auto& device = devices_[index];
    Instant due = back.not_before;
    if (!device.health.answering()) due = std::max(due, device.health.probe_at());
    if (candidate.key == bus::kNoDeadline) candidate.tie_break = back.order;
    const auto shape = bus::answer_shape(back.request.shape());
    consider(t, device.model->address, shape, due, candidate);
}

// The values read back are published like those of any other read.
bool LinePoller::Run::take_read_back(const bus::Outcome& outcome, const ReadBack& back, std::size_t device,
                                     std::span<const std::size_t> variables) {
    updates_.clear();
    bool same = true;
    for (const auto v : variables) {
        auto& variable = variables_[v];
        const auto& model = *variable.model;
        const auto read = value_in(outcome.response, back.request.start(), model);
        if (!model.read)
            updates_.push_back({variable.slot, read ? std::optional(*read) : std::nullopt});
        else if (model.read == back.request.function() && !splits_.has(v))
            note_value(variable, read);
        if (!model.verify) continue;
        const value::Value& sent = written_values_.sent(v);
        const bool equal = read && value::same(*read, sent);
        same = same && equal;
        commands_.note_read_back(v, equal || !read ? value::Value{} : *read);
        if (!equal && read && observer_)
            observer_->on_verify_failed(outcome.ended_at, plan_->line, device, index_in_device(v), sent,
                                        *read);
    }
    if (devices_[device].health.enabled()) {  // else it has no values
        store_.apply(outcome.ended_at, updates_);
        ages_->note_updates(updates_, outcome.sent_at, outcome.ended_at);
    }
    auto& statistics = devices_[device].statistics;
    ++(same ? statistics.verified : statistics.differed);
    return same;
}

void LinePoller::Run::on_group_read_back(const bus::Outcome& outcome, std::size_t index) {
    auto& request = requests_[index];
    const auto& write = write_groups_[index];
    auto& device = devices_[request.device];
    const OutcomeClass outcome_class = note_outcome(outcome, request.device, &request.counters);
    const Instant t = outcome.ended_at;
    write_groups_.transaction_ended(index);
    if (outcome_class.reason != Reason::ok) {
        if (reachable(device) && outcome_class.reason != Reason::link_lost)
            set_write_status(t, index, outcome_class.reason);
        device.writing = reachable(device) &&
                         write_groups_.read_back_again(t, index, outcome_class, device.model->attempts);
        if (!device.writing) finish_group(t, index, CommandResult::unknown, outcome_class.reason);
        return;
    }
    const bool same = take_read_back(outcome, *write.read_back, request.device, write.written());
    if (reachable(device)) set_write_status(t, index, same ? Reason::ok : Reason::differs);
    if (same) return finish_group(t, index, CommandResult::done, Reason::ok);
    commands_.note_differs(index);
    const bool again = write_groups_.repeatable(write.written());
    settle_group(t, index, {Reason::differs, true}, {CommandResult::refused, again});
}

void LinePoller::Run::on_command_read_back(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                           std::uint64_t order) {
    auto& command = commands_.at(order);
    auto& device = devices_[command.device];
    command.progress.transaction_ended();
    const Instant t = outcome.ended_at;
    const bool shows = outcome_class.reason != Reason::link_lost;
    if (outcome_class.reason != Reason::ok) {
        if (shows) statuses_.write_ended(t, command.variable, outcome_class.reason);
        device.writing =
            reachable(device) && command.alone.verify->again(t, outcome_class, device.model->attempts);
        if (!device.writing) settle_command(t, order, outcome_class, {CommandResult::unknown});
        return;
    }
    const bool same = take_read_back(outcome, *command.alone.verify, command.device, {&command.variable, 1});
    if (shows) statuses_.write_ended(t, command.variable, same ? Reason::ok : Reason::differs);
    if (same) return settle_command(t, order, {Reason::ok, true}, {CommandResult::done});
    command.execution = Execution::possible;
    const bool again = written_values_.model(command.variable).safe_to_repeat;
    settle_command(t, order, {Reason::differs, true}, {CommandResult::refused, again});
}

// A confirmed write that was not compared ends as unknown.
void LinePoller::Run::drop_read_backs(Instant t, std::size_t index, Reason reason) {
    for (const auto r : devices_[index].requests) {
        if (!write_groups_.has(r) || !write_groups_[r].progress.awaits_read_back()) continue;
        devices_[index].writing = false;
        finish_group(t, r, CommandResult::unknown, reason);
    }
    if (commands_.drop_read_backs(t, index, reason)) devices_[index].writing = false;
}

}  // namespace takt::poll
