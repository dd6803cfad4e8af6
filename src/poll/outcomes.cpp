// The effects of an outcome on values, devices and status variables.
#include <algorithm>
#include <utility>

#include "run.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

namespace {

constexpr int kRecentResponses = 8;  // whose mean DeviceStatistics::recent_time is, about

}  // namespace

// Counts the outcome and updates the health of the device. Called before the values are taken: it may degrade
// or restart the whole device.
OutcomeClass LinePoller::Run::note_outcome(const bus::Outcome& outcome, std::size_t index,
                                           bus::TransactionCounters* counters) {
    auto& device = devices_[index];
    --device.in_flight;
    if (writes(kind_of(outcome.id))) device.writing = false;
    count_outcome(device, outcome);
    if (counters) counters->count(outcome);
    note_busy(outcome);
    const OutcomeClass outcome_class = classify(outcome);
    const Instant t = outcome.ended_at;
    switch (device.health.ended(outcome.sent_at, t, outcome_class, device.in_flight > 0)) {
        case DeviceVerdict::ignored: return outcome_class;
        case DeviceVerdict::returned:
            restart_device(t, index, true);
            if (learner_) learner_->on_return(t, index);
            [[fallthrough]];
        case DeviceVerdict::answered:
            set_device_state(t, index, DeviceState::answering);
            return outcome_class;
        case DeviceVerdict::lost:
            set_device_state(t, index, DeviceState::not_answering);
            degrade_device(t, index, Reason::not_answering, true);
            if (device.health.probed()) drop_pending(t, index, Reason::not_answering);
            break;
        case DeviceVerdict::failed: break;
    }
    check_connection(t);
    return outcome_class;
}

void LinePoller::Run::count_outcome(DeviceRun& device, const bus::Outcome& outcome) {
    auto& statistics = device.statistics;
    const auto timed = statistics.counters.time.count();
    statistics.counters.count(outcome);
    const bool answered = statistics.counters.time.count() != timed;
    check_noise(device, outcome);
    const Duration time = outcome.ended_at - outcome.sent_at;
    if (answered)
        statistics.recent_time += timed == 0 ? time : (time - statistics.recent_time) / kRecentResponses;
    measure_delay(device, outcome, answered);
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
    const bool whole = !read.distinct || read.distinct->whole();
    const OutcomeClass outcome_class = note_outcome(outcome, request.device, &request.counters);
    const Instant t = outcome.ended_at;
    if (outcome.sent) request.attempt_time.record(t - outcome.sent_at);
    if (outcome_class.reason == Reason::ok && whole && !reads_.by_trigger(index))
        periods_.answered(outcome.sent_at, index);
    // The return of the device has released all its reads at once. This one has just been read.
    if (probe && outcome_class.reason == Reason::ok && whole) reads_.serve_release(t, index);
    if (outcome_class.reason == Reason::link_lost) {
        if (reads_.by_trigger(index)) reads_.again(t, index);
        return;
    }
    if (!devices_[request.device].health.enabled()) return;
    if (!outcome_class.answered) {
        fail_read(t, request, outcome_class.reason);
        return;
    }
    reads_.answered(t, index, outcome_class.busy);
    if (read.distinct && on_part(outcome, outcome_class, request)) return;
    if (outcome_class.reason == Reason::ok) {
        read.refusals = 0;
        take_values(t, request, outcome.request, outcome.response);
        ages_->note_read(request.variables, outcome.sent_at, outcome.ended_at);
    } else if (outcome_class.reason == Reason::ambiguous) {
        degrade(t, request.variables, Quality::uncertain, Reason::ambiguous, false);
        read_again(t, request);
    } else if (!refused_with_gaps(outcome, request, outcome_class.reason)) {
        degrade(t, request.variables, Quality::bad, outcome_class.reason, false);
    }
    statuses_.read_ended(t, index, outcome_class.reason);
}

void LinePoller::Run::take_values(Instant t, RequestRun& request, const wire::RequestShape& sent,
                                  const wire::ResponseView& response) {
    updates_.clear();
    for (const auto v : request.variables) take_value(request, sent, response, v);
    store_.apply(t, updates_);
}

// The read half of 0x17.
void LinePoller::Run::on_exchanged(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                                   RequestRun& request) {
    if (outcome_class.reason == Reason::ok) {
        take_values(outcome.ended_at, request, request.read->request.shape(), outcome.response);
        ages_->note_updates(updates_, outcome.sent_at, outcome.ended_at);
    } else if (outcome_class.reason != Reason::link_lost) {
        const bool refused = outcome_class.answered && outcome_class.reason != Reason::ambiguous;
        const auto quality = refused ? Quality::bad : Quality::uncertain;
        degrade(outcome.ended_at, request.variables, quality, outcome_class.reason, false);
    }
}

// Of 0x17 only variables in the range that it reads.
void LinePoller::Run::take_value(RequestRun& request, const wire::RequestShape& sent,
                                 const wire::ResponseView& response, std::size_t v) {
    auto& variable = variables_[v];
    const std::uint32_t first = variable.model->start();
    const std::uint32_t start = sent.start.value;
    const bool inside = first >= start && first + variable.model->items() <= start + sent.quantity;
    if (variable.model->read != wire::Function{sent.function} || (!inside && !splits_.has(v))) return;
    if (inside)
        note_value(variable, value_in(response, sent.start, *variable.model));
    else if (sent.quantity >= request.read->request.quantity())
        take_part(request, sent.start, response, v);
}

void LinePoller::Run::take_part(RequestRun& request, DataAddress start, const wire::ResponseView& response,
                                std::size_t v) {
    auto& variable = variables_[v];
    const auto& model = *variable.model;
    auto& split = *splits_.find(v);
    const auto index = static_cast<std::size_t>(&request - requests_.data());
    const auto* part = split.part_of(index);
    if (!part) return;
    const auto first = static_cast<std::uint16_t>(model.start() + part->first);
    const auto registers = registers_in(response, start, first, part->count);
    if (!registers) return note_value(variable, std::unexpected(registers.error()));
    split.take(index, reads_.round_of(index, model.period), registers->span());
    const auto whole = split.whole();
    if (!whole) return;
    note_value(variable, value::decode(value::layout_of(model), *whole));
    split.forget();
}

void LinePoller::Run::note_value(VariableRun& variable, const Result<value::Value>& value) {
    if (value) {
        written_values_.note_read(static_cast<std::size_t>(&variable - variables_.data()), *value);
        updates_.push_back({variable.slot, *value});
    } else {
        updates_.push_back({variable.slot, std::nullopt, Quality::bad, Reason::unexpected_reply});
    }
}

void LinePoller::Run::fail_read(Instant t, RequestRun& request, Reason reason) {
    const auto index = static_cast<std::size_t>(&request - requests_.data());
    const bool slowed = reads_.failed(t, index);
    statuses_.note_failed(index, reason);
    if (!devices_[request.device].health.answering()) return;
    if (slowed) {
        periods_.interrupt(index);
        degrade(t, request.variables, Quality::bad, reason, true);
    } else {
        degrade(t, request.variables, Quality::uncertain, reason, false);
        read_again(t, request);
    }
    statuses_.read_ended(t, index, reason);
}

void LinePoller::Run::read_again(Instant t, RequestRun& request) {
    reads_.again(t, static_cast<std::size_t>(&request - requests_.data()));
}

void LinePoller::Run::degrade(Instant t, std::span<const std::size_t> variables, Quality quality,
                              Reason reason, bool to_default) {
    updates_.clear();
    for (const auto v : variables) {
        const auto& variable = variables_[v];
        const auto& slot = store_[variable.slot];
        if (!variable.model->read || !variable.model->used) continue;
        value::Update update{variable.slot, std::nullopt, quality, reason};
        if (quality == Quality::uncertain && slot.quality != Quality::good) update.quality = slot.quality;
        if (const auto& initial = store_.info(variable.slot).initial;
            to_default && !variable.model->hold_last && !value::is_empty(initial))
            update.value = initial;
        updates_.push_back(update);
    }
    store_.apply(t, updates_);
}

void LinePoller::Run::degrade_device(Instant t, std::size_t index, Reason reason, bool to_default) {
    std::vector<std::size_t> variables;
    for (std::size_t v = 0; v < variables_.size(); ++v) {
        if (variables_[v].device != index) continue;
        variables.push_back(v);
        ages_->forget(v);
    }
    degrade(t, variables, Quality::bad, reason, to_default);
    for (const auto r : devices_[index].requests) periods_.interrupt(r);
    statuses_.device_away(t, index, reason);
}

}  // namespace takt::poll
