// Verification of writes: a write that the device confirmed is read back and compared.
#include "line/run.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

bool LinePoller::Run::take_read_back(const bus::Outcome& outcome, const WriteJob& write) {
    const auto& back = *write.read_back();
    const std::size_t device = write.device();
    give_up_held(device);
    publisher_.begin(outcome.sent_at,
                     quality_of(outcome.ended_at, device, outcome).value_or(value::Quality::uncertain));
    bool same = true;
    for (const auto v : write.written()) {
        const auto& model = *variables_[v].model;
        const auto read = value_in(outcome.response, back.request.start(), model);
        publisher_.read_back(v, back.request.function(), read);
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
        publisher_.publish(outcome.ended_at);
        ages_->note_updates(publisher_.updates(), outcome.sent_at, outcome.ended_at);
    }
    auto& statistics = devices_[device].statistics;
    ++(same ? statistics.verified : statistics.differed);
    return same;
}

// A group whose device is not reachable keeps the status of its write.
void LinePoller::Run::on_read_back(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                   WriteJob write) {
    auto& device = devices_[write.device()];
    const Instant t = outcome.ended_at;
    const bool shows = outcome_class.reason != Reason::link_lost && (!write.of_group() || reachable(device));
    if (outcome_class.reason != Reason::ok) {
        if (shows) set_write_status(t, write, outcome_class.reason);
        device.writing = reachable(device) && write.read_back_again(t, outcome_class, device.model->attempts);
        if (!device.writing) finish_write(t, write, CommandResult::unknown, outcome_class.reason);
        return;
    }
    const bool same = take_read_back(outcome, write);
    if (shows) set_write_status(t, write, same ? Reason::ok : Reason::differs);
    if (same) {
        if (!write.of_group())
            publisher_.show_written(t, write.written());  // also while its device is switched off
        return finish_write(t, write, CommandResult::done, Reason::ok);
    }
    write.note_differs();
    settle_write(t, write, {Reason::differs, true},
                 {CommandResult::refused, write.repeatable(write.written())});
}

// A confirmed write that was not compared ends as unknown.
void LinePoller::Run::drop_read_backs(Instant t, std::size_t index, Reason reason) {
    for (const auto r : devices_[index].requests) {
        if (!write_groups_.has(r) || !write_groups_[r].progress.awaits_read_back()) continue;
        devices_[index].writing = false;
        finish_write(t, write_job(transaction_id(JobKind::group_write, r)), CommandResult::unknown, reason);
    }
    if (commands_.drop_read_backs(t, index, reason)) devices_[index].writing = false;
}

}  // namespace takt::poll
