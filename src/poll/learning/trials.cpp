// gaps: learn. Trial reads are sent when no other request is due; their results lead to a new plan.
#include <algorithm>

#include "line/run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

using value::Quality;
using value::Reason;

constexpr unsigned kRefusalsToDoubt = 3;
constexpr Duration kSlowPeriod = std::chrono::minutes(1);  // values with longer periods do not delay a trial

}  // namespace

void LinePoller::Run::begin_learning(const plan::LinePlan& plan, const Options& options) {
    learner_ = std::make_unique<GapLearner>(project_, plan.line, options.plan_maker);
    plan_ = &learner_->plan();
}

// @returns whether a request may be submitted: not while a new plan waits for the transactions in flight
bool LinePoller::Run::keep_learning(Instant t) {
    if (!learner_) return true;
    learner_->update(t);
    if (!learner_->next_plan()) return true;
    if (!engine_.idle() && !modify_.second_step()) {
        arbiter_.begin();
        return false;
    }
    const bool between_two_steps = modify_.active() || std::ranges::any_of(devices_, &DeviceRun::writing);
    if (!between_two_steps) swap_plan(t);
    return true;
}

void LinePoller::Run::offer_trial(Instant t) {
    if (!learner_ || learner_->in_flight() || !link_.up_since()) return;
    const auto* const trial = learner_->next_trial(t, *this);
    if (!trial) return arbiter_.wake_at(learner_->wakeup(t));
    const auto& device = devices_[trial->device];
    if (!reachable(device) || full(device)) return;
    const Instant latest = learner_->latest_start(t);
    if (t < latest && !fits_before_polling(t, *trial)) return arbiter_.wake_at(latest);
    const auto shape = bus::answer_shape(wire::shape_of(trial->read));
    offers_.offer(t, device.model->address, shape, t, learner_->candidate(t, plan_->utilization > 1));
}

// Whether a trial is expected to end before the next polling is due.
bool LinePoller::Run::fits_before_polling(Instant t, const Learning::TrialRead& trial_read) const {
    const auto& device = *devices_[trial_read.device].model;
    const auto& read = trial_read.read;
    const Duration length =
        plan::bus_time(
            line_, device, wire::frame_length(line_.framing, 5),
            wire::frame_length(line_.framing, wire::response_pdu_length(read.function, read.quantity)),
            plan::estimated_turnaround(device)) +
        project_.host.overhead;
    const Instant end = after(t, length);
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        const auto& request = requests_[r];
        if (!reads_.waits(r) || !reachable(devices_[request.device])) continue;
        if (request.plan->period > Duration::zero() && reads_.released(r) < end) return false;
    }
    return true;
}

void LinePoller::Run::start_trial(Instant t) {
    const auto& trial = learner_->start(t);
    submit(t, trial.device, transaction_id(JobKind::trial, 0), Purpose::trial, prepared(trial.read));
}

// The outcome of a trial does not count for the health of its device.
void LinePoller::Run::on_trial(const bus::Outcome& outcome) {
    const std::size_t device = learner_->trial().device;
    --devices_[device].in_flight;
    count_outcome(device, outcome);
    note_busy(outcome);
    learner_->end(outcome);
    report_gap_events(outcome.ended_at);
}

void LinePoller::Run::report_gap_events(Instant t) {
    while (const auto event = learner_->take_event())
        if (observer_) observer_->on_learnt(t, plan_->line, *event);
}

Freshness LinePoller::Run::freshness(std::size_t index, wire::Function read, const model::ItemRange& items,
                                     Instant since) const {
    const auto& device = devices_[index];
    if (!device.health.enabled() || !device.health.answering()) return Freshness::not_yet;
    Freshness seen = Freshness::good;
    const auto& variables = device.model->variables;
    if (variables.empty()) return seen;
    const std::size_t first = slots_.variable({plan_->line, index, 0}).value - first_slot_;
    for (std::size_t v = first; v < first + variables.size(); ++v) {
        const auto& model = *variables_[v].model;
        const std::uint32_t start = model.start();
        if (!model.used || model.read != read || start > items.last || start + model.items() <= items.first)
            continue;
        const auto& slot = store_[variables_[v].slot];
        const bool waits = model.period <= kSlowPeriod;
        if (slot.quality == Quality::bad && value::is_exception(slot.reason)) return Freshness::refused;
        if (slot.quality != Quality::good || (waits && slot.good_at <= since)) seen = Freshness::not_yet;
    }
    return seen;
}

std::vector<model::ItemRange> LinePoller::Run::bridged_gaps(const RequestRun& request) const {
    const auto& device = *devices_[request.device].model;
    if (!learner_ || !plan::learns(device)) return {};
    const auto& read = request.read->request;
    return plan::gaps_in(
        device, read.function(),
        {read.start().value, static_cast<std::uint16_t>(read.start().value + read.quantity() - 1)});
}

// A refused read across gaps is repeated, so that a device that refuses now and then keeps its groups. After
// kRefusalsToDoubt refusals the gaps are unconfirmed and tested again.
bool LinePoller::Run::refused_with_gaps(const bus::Outcome& outcome, std::size_t index, Reason reason) {
    if (outcome.status != bus::Status::exception || !GapLearner::refuses(outcome.exception)) return false;
    auto& request = requests_[index];
    const auto gaps = bridged_gaps(request);
    if (gaps.empty()) return false;
    const Instant t = outcome.ended_at;
    auto& read = *request.read;
    degrade_read(t, index, Quality::uncertain, reason, Shown::last);
    reads_.again(t, index);
    if (++read.refusals < kRefusalsToDoubt) return true;
    read.refusals = 0;
    reads_.hold_back(t, index);
    learner_->doubt(request.device, read.request.function(), gaps);
    report_gap_events(t);
    return true;
}

}  // namespace takt::poll
