// gaps: learn. Trial reads are sent when no other request is due; their results lead to a new plan.
#include <algorithm>
#include <utility>

#include "run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

using value::Quality;
using value::Reason;

constexpr Duration kMaxTrialDelay = std::chrono::seconds(2);
constexpr unsigned kRefusalsToDoubt = 3;
constexpr Duration kSlowPeriod = std::chrono::minutes(1);  // values with longer periods do not delay a trial

// Exceptions that devices use for addresses they do not have.
bool refuses(std::uint8_t code) {
    return code >= 1 && code <= 4;
}

}  // namespace

void LinePoller::Run::begin_learning(const plan::LinePlan& plan, const Options& options) {
    auto first = plan::learning_plan(project_, plan.line);
    learner_ = std::make_unique<GapLearner>(GapLearner{.learning = Learning(line_),
                                                       .plan_maker = options.plan_maker,
                                                       .plan = std::move(first.plan),
                                                       .trials = std::move(first.trials)});
    plan_ = &learner_->plan;
}

// @returns whether a request may be submitted: not while a new plan waits for the transactions in flight
bool LinePoller::Run::keep_learning(Instant t) {
    if (!learner_) return true;
    if (learner_->trials) learner_->learning.set_trials(t, *std::exchange(learner_->trials, std::nullopt));
    if (!learner_->next_plan && !learner_->plan_wanted && learner_->learning.wants_plan(t)) {
        learner_->plan_wanted = true;
        auto learnt = learner_->learning.learnt(t);
        if (learner_->plan_maker)
            learner_->plan_maker->want_plan(plan_->line, std::move(learnt));
        else
            learner_->next_plan = plan::learning_plan(project_, plan_->line, learnt);
    }
    if (!learner_->next_plan) return true;
    if (!engine_.idle() && !modify_.second_step()) {
        wakeup_ = kNever;
        return false;
    }
    const bool between_two_steps = modify_.active() || std::ranges::any_of(devices_, &DeviceRun::writing);
    if (!between_two_steps) swap_plan(t);
    return true;
}

void LinePoller::Run::consider_trial(Instant t, std::optional<Candidate>& best) {
    if (!learner_ || learner_->learning.waiting() || !up_since_) return;
    learner_->trial_read = learner_->learning.next(t, *this);
    if (!learner_->trial_read) {
        learner_->waiting_since.reset();
        return wake_at(learner_->learning.wakeup(t));
    }
    const auto& device = devices_[learner_->trial_read->device];
    if (!reachable(device) || full(device)) return;
    if (!learner_->waiting_since) learner_->waiting_since = t;
    const Instant delay_ends = after(*learner_->waiting_since, kMaxTrialDelay);
    const bool can_wait = t < delay_ends;
    if (can_wait && !fits_before_polling(t, *learner_->trial_read)) return wake_at(delay_ends);
    const bool overloaded = plan_->utilization > 1;
    const Candidate candidate{
        !can_wait && overloaded ? Urgency::overdue : Urgency::background,
        (!can_wait && overloaded ? delay_ends : learner_->last_start).time_since_epoch().count(), 0,
        JobKind::trial, 0};
    const auto shape = bus::answer_shape(wire::shape_of(learner_->trial_read->read));
    consider(t, device.model->address, shape, t, candidate, best);
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
    return std::ranges::none_of(requests_, [&](const RequestRun& request) {
        if (!request.read || !request.read->polled || request.read->in_flight) return false;
        if (!reachable(devices_[request.device]) || !(request.plan->period > Duration::zero())) return false;
        const auto& polled = *request.read;
        return std::max(polled.retry.value_or(polled.release.next()), polled.not_before) < end;
    });
}

void LinePoller::Run::start_trial(Instant t) {
    learner_->waiting_since.reset();
    learner_->last_start = t;
    learner_->learning.asked();
    submit(t, learner_->trial_read->device, transaction_id(JobKind::trial, 0), Purpose::trial,
           prepared(learner_->trial_read->read));
}

// The outcome of a trial does not count for the health of its device.
void LinePoller::Run::on_trial(const bus::Outcome& outcome) {
    auto& device = devices_[learner_->trial_read->device];
    --device.in_flight;
    count_outcome(device, outcome);
    note_busy(outcome);
    const Instant t = outcome.ended_at;
    const bool exception = outcome.status == bus::Status::exception;
    if (outcome.status == bus::Status::ok)
        learner_->learning.on_taken(t);
    else if (exception && refuses(outcome.exception))
        learner_->learning.on_refused(t, outcome.exception);
    else
        learner_->learning.on_nothing(
            t, outcome.sent && !exception && classify(outcome).reason != Reason::link_lost);
    report_gap_events(t);
}

void LinePoller::Run::report_gap_events(Instant t) {
    while (const auto event = learner_->learning.take_event())
        if (observer_) observer_->on_learnt(t, plan_->line, *event);
}

Freshness LinePoller::Run::freshness(std::size_t index, wire::Function read, const model::ItemRange& items,
                                     Instant since) const {
    const auto& device = devices_[index];
    if (!device.enabled || !device.health.answering()) return Freshness::not_yet;
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
bool LinePoller::Run::refused_with_gaps(const bus::Outcome& outcome, RequestRun& request, Reason reason) {
    if (outcome.status != bus::Status::exception || !refuses(outcome.exception)) return false;
    const auto gaps = bridged_gaps(request);
    if (gaps.empty()) return false;
    const Instant t = outcome.ended_at;
    auto& read = *request.read;
    degrade(t, request.variables, Quality::uncertain, reason, false);
    if (read.by_trigger)
        read.triggered = read.trigger->event.admitted = true;
    else
        read.retry = t;
    if (++read.refusals < kRefusalsToDoubt) return true;
    read.refusals = 0;
    read.not_before = after(t, read.busy.next());
    for (const auto& gap : gaps) learner_->learning.doubt(request.device, read.request.function(), gap);
    report_gap_events(t);
    return true;
}

}  // namespace takt::poll
