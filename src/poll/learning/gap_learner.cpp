#include "learning/gap_learner.hpp"

#include <utility>

#include "devices/outcome_class.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

constexpr Duration kMaxTrialDelay = std::chrono::seconds(2);

}  // namespace

GapLearner::GapLearner(const model::Project& project, std::size_t line, PlanMaker* maker)
    : project_(project), line_(line), maker_(maker), learning_(project.lines[line]) {
    auto first = plan::learning_plan(project, line);
    plan_ = std::move(first.plan);
    trials_ = std::move(first.trials);
}

// ---- the plan

void GapLearner::update(Instant t) {
    if (trials_) learning_.set_trials(t, *std::exchange(trials_, std::nullopt));
    if (next_plan_ || plan_wanted_ || !learning_.wants_plan(t)) return;
    plan_wanted_ = true;
    auto learnt = learning_.learnt(t);
    if (maker_)
        maker_->want_plan(line_, std::move(learnt));
    else
        next_plan_ = plan::learning_plan(project_, line_, learnt);
}

plan::LinePlan GapLearner::swap_plan() {
    TAKT_ASSERT(next_plan_);
    auto next = *std::exchange(next_plan_, std::nullopt);
    trials_ = std::move(next.trials);
    return std::exchange(plan_, std::move(next.plan));
}

void GapLearner::plan_runs(Instant t) {
    plan_wanted_ = false;
    learning_.plan_is_made();
    learning_.set_trials(t, *std::exchange(trials_, std::nullopt));
}

// ---- trial reads

const Learning::TrialRead* GapLearner::next_trial(Instant t, const FreshnessProbe& probe) {
    trial_ = learning_.next(t, probe);
    if (!trial_) waiting_since_.reset();
    return trial_ ? &*trial_ : nullptr;
}

Instant GapLearner::latest_start(Instant t) {
    if (!waiting_since_) waiting_since_ = t;
    return after(*waiting_since_, kMaxTrialDelay);
}

Candidate GapLearner::candidate(Instant t, bool overloaded) {
    const Instant latest = latest_start(t);
    const bool urgent = t >= latest && overloaded;
    return {.urgency = urgent ? Urgency::overdue : Urgency::background,
            .key = (urgent ? latest : last_start_).time_since_epoch().count(),
            .job = transaction_id(JobKind::trial, 0)};
}

const Learning::TrialRead& GapLearner::start(Instant t) {
    waiting_since_.reset();
    last_start_ = t;
    learning_.asked();
    return *trial_;
}

void GapLearner::end(const bus::Outcome& outcome) {
    const Instant t = outcome.ended_at;
    const bool exception = outcome.status == bus::Status::exception;
    if (outcome.status == bus::Status::ok)
        learning_.on_taken(t);
    else if (exception && refuses(outcome.exception))
        learning_.on_refused(t, outcome.exception);
    else
        learning_.on_nothing(
            t, outcome.sent && !exception && classify(outcome).reason != value::Reason::link_lost);
}

// ---- observations of polling

void GapLearner::doubt(std::size_t device, wire::Function read, std::span<const model::ItemRange> gaps) {
    for (const auto& gap : gaps) learning_.doubt(device, read, gap);
}

}  // namespace takt::poll
