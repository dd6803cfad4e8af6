// Verification of writes: a write that the device confirmed is read back and compared.
#include <algorithm>

#include "run.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

void LinePoller::Run::await_read_back(std::size_t device, WriteProgress& progress, ReadBack& back,
                                      std::uint64_t order) {
    progress.verify();
    back.begin(order);
    devices_[device].writing = true;
}

void LinePoller::Run::consider_read_back(Instant t, std::size_t index, const ReadBack& back,
                                         Candidate candidate, std::optional<Candidate>& best) {
    const auto& device = devices_[index];
    Instant due = back.not_before;
    if (!device.health.answering()) due = std::max(due, device.health.probe_at());
    if (candidate.key == kNoDeadline) candidate.tie_break = back.order;
    const auto shape = bus::answer_shape(back.request.shape());
    consider(t, device.model->address, shape, due, candidate, best);
}

void LinePoller::Run::start_read_back(Instant t, std::size_t device, bus::TransactionId id,
                                      WriteProgress& progress, const ReadBack& back) {
    progress.read_back();
    submit(t, device, id, Purpose::read_back, back.request);
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
        else if (model.read == back.request.function() && !variable.split)
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
    if (devices_[device].enabled) {  // else it has no values
        store_.apply(outcome.ended_at, updates_);
        note_ages_of_updates(outcome);
    }
    auto& statistics = devices_[device].statistics;
    ++(same ? statistics.verified : statistics.differed);
    return same;
}

// A read may always be repeated.
bool LinePoller::Run::read_back_again(Instant t, std::size_t index, const OutcomeClass& outcome_class,
                                      ReadBack& back) {
    auto& device = devices_[index];
    const bool transient =
        outcome_class.reason != Reason::link_lost && (!outcome_class.answered || outcome_class.busy);
    if (!transient || !reachable(device) || ++back.failures >= device.model->attempts) return false;
    if (outcome_class.busy) back.not_before = after(t, back.busy.next());
    device.writing = true;
    return true;
}

void LinePoller::Run::on_group_read_back(const bus::Outcome& outcome, std::size_t index) {
    auto& request = requests_[index];
    auto& write = *request.write;
    auto& back = *write.read_back;
    const OutcomeClass outcome_class = note_outcome(outcome, request.device, &request.counters);
    const Instant t = outcome.ended_at;
    write.progress.transaction_ended();
    if (outcome_class.reason != Reason::ok) {
        if (reachable(devices_[request.device]) && outcome_class.reason != Reason::link_lost)
            set_write_status(t, request, outcome_class.reason);
        if (read_back_again(t, request.device, outcome_class, back)) return;
        return finish_group(t, index, CommandResult::unknown, outcome_class.reason);
    }
    const auto& members = write.writes_bits() ? write.sending : write.members;
    const bool same = take_read_back(outcome, back, request.device, members);
    if (reachable(devices_[request.device]))
        set_write_status(t, request, same ? Reason::ok : Reason::differs);
    if (same) return finish_group(t, index, CommandResult::done, Reason::ok);
    commands_.note_differs(index);
    const bool again = repeatable(members);
    settle_group(t, index, {Reason::differs, true}, {CommandResult::refused, again});
}

void LinePoller::Run::on_command_read_back(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                           std::uint64_t order) {
    auto& command = commands_.at(order);
    const auto& variable = variables_[command.variable];
    auto& back = *command.alone.verify;
    command.progress.transaction_ended();
    const Instant t = outcome.ended_at;
    const bool shows = outcome_class.reason != Reason::link_lost;
    if (outcome_class.reason != Reason::ok) {
        if (shows) set_variable_status(t, command.variable, outcome_class.reason);
        if (read_back_again(t, variable.device, outcome_class, back)) return;
        return settle_command(t, order, outcome_class, {CommandResult::unknown});
    }
    const bool same = take_read_back(outcome, back, variable.device, {&command.variable, 1});
    if (shows) set_variable_status(t, command.variable, same ? Reason::ok : Reason::differs);
    if (same) return settle_command(t, order, {Reason::ok, true}, {CommandResult::done});
    command.execution = Execution::possible;
    const bool again = variable.model->safe_to_repeat;
    settle_command(t, order, {Reason::differs, true}, {CommandResult::refused, again});
}

// A confirmed write that was not compared ends as unknown.
void LinePoller::Run::drop_read_backs(Instant t, std::size_t index, Reason reason) {
    for (const auto r : devices_[index].requests) {
        const auto& write = requests_[r].write;
        if (!write || !write->progress.awaits_read_back()) continue;
        devices_[index].writing = false;
        finish_group(t, r, CommandResult::unknown, reason);
    }
    if (commands_.drop_read_backs(t, index, reason)) devices_[index].writing = false;
}

}  // namespace takt::poll
