// Chooses the next request (RequestOffers, bus::Arbiter), submits it to the engine, and dispatches its
// outcome.
#include <algorithm>
#include <utility>

#include "line/run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

constexpr std::uint64_t kLengthsToReport = 2;

}  // namespace

Bytes LinePoller::Run::transmit(Instant t) {
    if (!keep_learning(t)) return engine_.transmit(t);  // a plan swap waits for the transactions in flight
    if (link_.state() == LinkState::closed) look_ahead(t);
    if (may_submit()) choose(t);
    return engine_.transmit(t);
}

Instant LinePoller::Run::next_wakeup() const {
    Instant wakeup = std::min(engine_.next_wakeup(), ages_->next());
    wakeup = std::min({wakeup, periods_.next_overrun(), held_until()});
    if (may_submit()) wakeup = std::min({wakeup, arbiter_.wakeup(), link_.closes_at()});
    if (link_.state() == LinkState::closed) wakeup = std::min(wakeup, arbiter_.wakeup());
    return std::min(wakeup, commands_.next_expiry());
}

// A request on a connection that is about to be closed would be lost, and its device charged.
bool LinePoller::Run::must_reconnect() const {
    return engine_.must_reconnect() || link_.given_up() || link_.done();
}

bool LinePoller::Run::may_submit() const {
    const bool alone = closes_.one_at_a_time() || link_.one_request();
    return engine_.can_submit() && !must_reconnect() && (!alone || engine_.idle());
}

// While the link is closed: whether something is due, for which it is opened.
void LinePoller::Run::look_ahead(Instant t) {
    arbiter_.begin();
    if (!modify_.second_step()) offer(t);
    link_.need(modify_.second_step() || arbiter_.best());
}

void LinePoller::Run::choose(Instant t) {
    arbiter_.begin();
    if (modify_.second_step()) return continue_modify(t);
    if (modify_.active()) return;
    if (link_.ends_after_request() && engine_.idle()) return link_.finish();
    offer(t);
    report_waiting_writes(t);
    if (const auto candidate = arbiter_.choose()) return start(t, *candidate);
    if (t >= link_.closes_at() && engine_.idle()) link_.finish();
}

void LinePoller::Run::offer(Instant t) {
    if (suspended_) {
        offers_.offer_writes(t);
    } else {
        offers_.offer_requests(t);
        offer_relayed(t);
        offer_trial(t);
        offer_spare_relayed(t);
        offers_.offer_early_probes(t);
    }
}

void LinePoller::Run::start(Instant t, const Candidate& candidate) {
    arbiter_.started(candidate);
    const auto index = index_of(candidate.job);
    switch (kind_of(candidate.job)) {
        case JobKind::read: start_read(t, index, candidate.by_trigger); return;
        case JobKind::group_write:
        case JobKind::command: start_write(t, candidate.job); return;
        case JobKind::trial: start_trial(t); return;
        case JobKind::relayed: start_relayed(t); return;
    }
}

void LinePoller::Run::start_read(Instant t, std::size_t index, bool by_trigger) {
    auto& request = requests_[index];
    auto& read = *request.read;
    read.last_start = t;
    auto& health = devices_[request.device].health;
    health.read_started(t, request.plan->period.value_or(Duration::zero()));
    const ReadCause cause = reads_.start(t, index, by_trigger);
    const Purpose purpose = !health.answering()              ? Purpose::probe
                            : by_trigger                     ? Purpose::trigger
                            : cause == ReadCause::repetition ? Purpose::repetition
                                                             : Purpose::period;
    if (!by_trigger) {
        arbiter_.advance_round(index);
        devices_[request.device].relayed_last = false;
    }
    // A probe has its own interval.
    if (cause == ReadCause::release && health.answering() && !reads_.slowed(index) &&
        periods_.started(t, index))
        report_overrun(t, index, periods_.request(index).overrun());
    submit(t, request.device, transaction_id(JobKind::read, index), purpose, offers_.read_to_send(t, index));
}

void LinePoller::Run::start_write(Instant t, bus::TransactionId id) {
    auto write = write_job(id);
    if (write.progress().awaits_read_back()) {
        write.read_back_submitted();
        return submit(t, write.device(), id, Purpose::read_back, write.read_back()->request);
    }
    const bool modifies = write.modifies();
    if (modifies && devices_[write.device()].in_flight > 0) return;  // it waits until the device has answered
    const auto first = write.begin();
    if (!first) {
        finish_write(t, write, value::CommandResult::refused, value::Reason::ok);
        return arbiter_.wake_at(t);
    }
    if (modifies) modify_.begin();
    submit(t, write.device(), id, modifies ? Purpose::before_write : Purpose::write, *first);
}

// Of a transaction that passes the admission of the line: whether it has taken its token. Else nullptr.
bool* LinePoller::Run::unlimited_event(bus::TransactionId id) {
    const auto index = index_of(id);
    switch (kind_of(id)) {
        case JobKind::read: return reads_.by_trigger(index) ? reads_.line_token(index) : nullptr;
        case JobKind::group_write:
        case JobKind::command: return write_job(id).line_token();
        case JobKind::trial:
        case JobKind::relayed: break;
    }
    return nullptr;
}

void LinePoller::Run::report_sending(Instant t, std::size_t device, bus::TransactionId id, Purpose purpose) {
    const bool early = purpose == Purpose::probe && devices_[device].health.probes_early();
    Sending sending{.purpose = purpose, .early = early, .device = device};
    const auto index = index_of(id);
    if (kind_of(id) == JobKind::command)
        sending.command = commands_.at(index).command.id;
    else if (kind_of(id) != JobKind::trial)
        sending.request = index;
    observer_->on_sending(t, plan_->line, sending);
}

void LinePoller::Run::submit(Instant t, std::size_t index, bus::TransactionId id, Purpose purpose,
                             const wire::PreparedRequest& request) {
    if (observer_) report_sending(t, index, id, purpose);
    auto& device = devices_[index];
    ++device.in_flight;
    if (writes(kind_of(id))) device.writing = true;
    if (bool* const started = unlimited_event(id)) arbiter_.event_started(t, *started);
    bus::Transaction transaction{.id = id, .unit = device.model->address, .request = request};
    set_times(device, transaction);
    const auto taken = engine_.submit(t, transaction);
    TAKT_ASSERT(taken);
}

// A transaction that was never sent because the link is down is no exchange.
void LinePoller::Run::report_failure(const bus::Outcome& outcome) {
    using bus::Status;
    const bool lost = outcome.status == Status::link_lost || outcome.status == Status::cancelled;
    if (!observer_ || outcome.status == Status::ok || (lost && !outcome.sent)) return;
    FailedExchange failed{.device = device_at(outcome.unit),
                          .unit = outcome.unit,
                          .request = outcome.request,
                          .status = outcome.status,
                          .exception = outcome.exception,
                          .instead = outcome.instead,
                          .took = outcome.ended_at - outcome.sent_at};
    if (failed.device) {
        const auto& device = devices_[*failed.device];
        failed.attempts = std::max<std::uint16_t>(device.model->attempts, 1);
        failed.attempt = std::min<std::uint16_t>(device.health.failures() + 1, failed.attempts);
        if (device.health.probed()) failed.kind = FailedExchange::Kind::probe;
    }
    if (kind_of(outcome.id) == JobKind::relayed) failed.kind = FailedExchange::Kind::relayed;
    if (failed.kind != FailedExchange::Kind::attempt) failed.attempt = failed.attempts = 1;
    observer_->on_failed(outcome.ended_at, plan_->line, failed);
}

bool LinePoller::Run::lengths_are_off() const {
    return !engine_.config().length_tolerance && engine_.counters().lengths_off >= kLengthsToReport;
}

void LinePoller::Run::on_outcome(const bus::Outcome& outcome) {
    report_failure(outcome);
    if (observer_ && !lengths_reported_ && lengths_are_off()) {
        lengths_reported_ = true;
        observer_->on_lengths_off(outcome.ended_at, plan_->line);
    }
    if (outcome.sent) {
        closes_.ended(outcome);
        if (outcome.status != bus::Status::link_lost)
            link_.request_ended(outcome.ended_at, !outcome.response.empty());
    }
    note_in_step(outcome);
    const auto index = index_of(outcome.id);
    if (unlimited_event(outcome.id)) arbiter_.event_ended(std::max(outcome.ended_at, offers_.line_free()));
    switch (kind_of(outcome.id)) {
        case JobKind::read:
            on_read(outcome, index);
            offers_.note_event(index);
            return;
        case JobKind::group_write:
        case JobKind::command: on_written(outcome); return;
        case JobKind::trial: on_trial(outcome); return;
        case JobKind::relayed: on_relayed(outcome); return;
    }
}

}  // namespace takt::poll
