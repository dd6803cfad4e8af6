// The effects of an outcome on values, devices and status variables.
#include <algorithm>
#include <utility>

#include "line/run.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

namespace {

constexpr int kRecentResponses = 8;  // whose mean DeviceStatistics::recent_time is, about

}  // namespace

void RequestTraffic::count(const bus::Outcome& outcome, Duration silence, Duration cost) {
    const auto timed = counters.time.count();
    counters.count(outcome);
    if (counters.time.count() == timed) return;
    const Duration time = outcome.ended_at - outcome.sent_at;
    if (!times) times = HeapOptional(CompactLatencyStatistics());
    times->record(time);
    if (time > cost - silence) ++over_cost;
}

// Counts the outcome and updates the health of the device. Called before the values are taken: it may degrade
// or restart the whole device.
OutcomeClass LinePoller::Run::note_outcome(const bus::Outcome& outcome, std::size_t index,
                                           RequestRun* request) {
    auto& device = devices_[index];
    --device.in_flight;
    if (writes(kind_of(outcome.id))) device.writing = false;
    count_outcome(index, outcome);
    if (request) {
        request->traffic.count(outcome, engine_.silence(),
                               writes(kind_of(outcome.id)) ? request->write_cost : request->read_cost);
        const bool refused = outcome.status == bus::Status::exception;
        if (refused ? request->traffic.counters.answered > 0 : outcome.status == bus::Status::ok)
            device.statistics.refusals.ended(outcome.ended_at, !refused);
    }
    note_busy(outcome);
    const OutcomeClass outcome_class = classify(outcome);
    const Instant t = outcome.ended_at;
    if (!outcome_class.answered || outcome_class.reason == Reason::ambiguous) periods_.failed(t);
    const bool closed_before = device.health.condition().failure == Reason::closed;
    switch (device.health.ended(outcome.sent_at, t, outcome_class, device.in_flight > 0)) {
        case DeviceVerdict::ignored: return outcome_class;
        case DeviceVerdict::returned:
            if (closed_before) {
                resume_device(index);  // it answered some reads: they keep their periods
            } else {
                restart_device(t, index);
                reads_.release_at_once(t, index, publisher_.splits());
            }
            if (learner_) learner_->on_return(t, index);
            [[fallthrough]];
        case DeviceVerdict::answered:
            set_device_state(t, index, DeviceState::answering);
            return outcome_class;
        case DeviceVerdict::lost:
            set_device_state(t, index, DeviceState::not_answering);
            degrade_device(t, index, Reason::not_answering, Shown::initial);
            if (device.health.probed()) drop_pending(t, index, Reason::not_answering);
            break;
        case DeviceVerdict::failed: break;
    }
    check_connection(t);
    return outcome_class;
}

void LinePoller::Run::count_outcome(std::size_t index, const bus::Outcome& outcome) {
    auto& device = devices_[index];
    auto& statistics = device.statistics;
    const auto timed = statistics.counters.time.count();
    statistics.counters.count(outcome);
    const bool answered = statistics.counters.time.count() != timed;
    if (device.noise_meter.add(outcome.noise, statistics.counters) && observer_)
        observer_->on_noise(outcome.ended_at, plan_->line, index, *device.noise_meter.finding());
    const Duration time = outcome.ended_at - outcome.sent_at;
    if (answered)
        statistics.recent_time += timed == 0 ? time : (time - statistics.recent_time) / kRecentResponses;
    if (const auto surplus = std::exchange(undecided_surplus_, std::nullopt);
        surplus && !misdirected(outcome))
        count_surplus(*surplus);
    if (outcome.instead && outcome.status == bus::Status::bad_checksum) {
        ++statistics.cut_short;
        statistics.last_cut_short = outcome.instead;
    } else if (outcome.instead) {
        if (misdirected(outcome)) ++statistics.foreign;
        statistics.last_foreign = outcome.instead;
    }
    measure_delay(index, outcome, answered);
}

void LinePoller::Run::note_busy(const bus::Outcome& outcome) {
    if (!outcome.sent) return;
    const Duration busy = engine_.silence() + (outcome.ended_at - outcome.sent_at);
    load_.add(outcome.ended_at, busy);
}

void LinePoller::Run::on_read(const bus::Outcome& outcome, std::size_t index) {
    auto& request = requests_[index];
    auto& read = *request.read;
    reads_.ended(index);
    const bool probe = !devices_[request.device].health.answering();
    const bool whole = distinct_reads_.whole(index);
    const OutcomeClass outcome_class = note_outcome(outcome, request.device, &request);
    const Instant t = outcome.ended_at;
    if (outcome.sent) request.traffic.attempt_time.record(t - outcome.sent_at);
    if (outcome_class.reason == Reason::ok && whole && !reads_.by_trigger(index) &&
        periods_.answered(outcome.sent_at, t, index))
        ++request.traffic.late_refreshes;
    // The return of the device has released all its reads at once. This one has just been read, or is read
    // again for another cause: a part, or a response in doubt.
    if (probe && (outcome_class.reason == Reason::ok || outcome_class.reason == Reason::ambiguous))
        reads_.serve_release(t, index);
    if (outcome_class.reason == Reason::link_lost) {
        if (!outcome.sent || reads_.by_trigger(index) || reads_.lost_by_close(index)) reads_.again(t, index);
        return;
    }
    if (!devices_[request.device].health.enabled()) return;
    if (!outcome_class.answered) {
        fail_read(outcome, index, outcome_class.reason);
        return;
    }
    reads_.answered(t, index, outcome_class.busy);
    if (on_part(outcome, outcome_class, index)) return;
    if (outcome_class.reason == Reason::ok) {
        read.refusals = 0;
        take_values(outcome, index, outcome.request, true);
    } else if (outcome_class.reason == Reason::ambiguous) {
        degrade_read(t, index, Quality::uncertain, Reason::ambiguous, Shown::last);
        reads_.again(t, index);
    } else if (!refused_with_gaps(outcome, index, outcome_class.reason)) {
        degrade_read(t, index, Quality::bad, outcome_class.reason, Shown::last);
    }
    statuses_.read_ended(t, index, outcome_class.reason);
}

// The read half of 0x17.
void LinePoller::Run::on_exchanged(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                   std::size_t index) {
    const auto& request = requests_[index];
    if (outcome_class.reason == Reason::ok) {
        take_values(outcome, index, request.read->request.shape(), false);
    } else if (outcome_class.reason != Reason::link_lost) {
        const bool refused = outcome_class.answered && outcome_class.reason != Reason::ambiguous;
        const auto quality = refused ? Quality::bad : Quality::uncertain;
        degrade_read(outcome.ended_at, index, quality, outcome_class.reason, Shown::last);
    }
}

void LinePoller::Run::fail_read(const bus::Outcome& outcome, std::size_t index, Reason reason) {
    const auto& request = requests_[index];
    const Instant t = outcome.ended_at;
    const bool slowed = reads_.failed(t, index);
    const bool closes = reason == Reason::closed || outcome.out_of_step;
    const bool repeats = !closes || reads_.lost_by_close(index);
    statuses_.note_failed(index, reason);
    if (!devices_[request.device].health.answering()) return;
    if (slowed) {
        periods_.interrupt(index);
        degrade_read(t, index, Quality::bad, reason, Shown::initial);
    } else {
        // On the next connection it is repeated at once: the values change only if that fails, too.
        if (!closes || !repeats) degrade_read(t, index, Quality::uncertain, reason, Shown::last);
        if (repeats) reads_.again(t, index);
    }
    statuses_.read_ended(t, index, reason);
}

// The values of earlier reads come before that.
void LinePoller::Run::degrade_read(Instant t, std::size_t index, Quality quality, Reason reason,
                                   Shown shown) {
    give_up_held(requests_[index].device);
    publisher_.degrade(t, requests_[index].variables, quality, reason, shown);
}

void LinePoller::Run::degrade_device(Instant t, std::size_t index, Reason reason, Shown shown) {
    give_up_held(index);
    std::vector<std::size_t> variables;
    for (std::size_t v = 0; v < variables_.size(); ++v) {
        if (variables_[v].device != index) continue;
        variables.push_back(v);
        ages_->forget(v);
    }
    publisher_.degrade(t, variables, Quality::bad, reason, shown);
    for (const auto r : devices_[index].requests) periods_.interrupt(r);
    statuses_.device_away(t, index, reason);
}

}  // namespace takt::poll
