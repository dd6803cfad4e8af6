// gaps: learn. Trial reads, and the plans that their results lead to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "learning/learning.hpp"
#include "line/job_id.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/plan/learning.hpp"
#include "takt/poll/gap_event.hpp"

namespace takt::poll {

/// Learns the gaps of one line (Learning), owns the plan that follows from what is known, and gives each
/// trial read the moment by which it must start.
///
/// A new plan is requested when the knowledge has changed. It waits until the caller can swap it in.
///
/// The caller sends the trial reads and reports their outcomes. One owner, one thread; the project and the
/// plan maker must outlive it. Plans allocate; a choice does not.
class GapLearner {
public:
    /// @param line  of the project
    /// @param maker  makes the plans; nullptr: they are made at once
    GapLearner(const model::Project& project, std::size_t line, PlanMaker* maker);

    // ---- the plan

    [[nodiscard]] const plan::LinePlan& plan() const { return plan_; }
    /// Requests a plan if the knowledge has changed. Call it before each choice.
    void update(Instant t);
    /// A plan from the plan maker.
    void offer(plan::LearningPlan next) { next_plan_ = std::move(next); }
    /// nullptr: no plan waits.
    [[nodiscard]] const plan::LinePlan* next_plan() const { return next_plan_ ? &next_plan_->plan : nullptr; }
    /// The plan that waits is the plan from now on. plan_runs() must follow.
    /// @returns the one before
    [[nodiscard]] plan::LinePlan swap_plan();
    /// The requests of the new plan are set up.
    void plan_runs(Instant t);

    // ---- trial reads

    /// One was started and has not ended.
    [[nodiscard]] bool in_flight() const { return learning_.waiting(); }
    /// Looks for the next trial read. None is in flight.
    /// @returns nullptr: look again at wakeup(), or when a value was read
    [[nodiscard]] const Learning::TrialRead* next_trial(Instant t, const FreshnessProbe& probe);
    [[nodiscard]] Instant wakeup(Instant t) const { return learning_.wakeup(t); }
    /// The trial read of next_trial() could be sent at `t`.
    /// @returns when it is sent at the latest, though it delays polling
    [[nodiscard]] Instant latest_start(Instant t);
    /// Its position among what may be sent. @param overloaded  the line never has time without due requests
    [[nodiscard]] Candidate candidate(Instant t, bool overloaded);
    /// It is sent. @returns it
    const Learning::TrialRead& start(Instant t);
    /// The trial read in flight, or the last one.
    [[nodiscard]] const Learning::TrialRead& trial() const { return *trial_; }
    void end(const bus::Outcome& outcome);

    // ---- observations of polling

    /// Whether devices use this exception for addresses that they do not have.
    [[nodiscard]] static bool refuses(std::uint8_t code) { return code >= 1 && code <= 4; }
    /// A polled read across these gaps was refused several times: they are unconfirmed from now on.
    void doubt(std::size_t device, wire::Function read, std::span<const model::ItemRange> gaps);
    void on_return(Instant t, std::size_t device) { learning_.on_return(t, device); }

    [[nodiscard]] std::optional<GapEvent> take_event() { return learning_.take_event(); }
    [[nodiscard]] const Learning& learning() const { return learning_; }

private:
    const model::Project& project_;
    std::size_t line_;
    PlanMaker* maker_;
    Learning learning_;
    plan::LinePlan plan_;
    std::optional<std::vector<plan::Trial>> trials_;  // of the plan, not given to `learning_` yet
    bool plan_wanted_ = false;                        // requested from the plan maker
    std::optional<plan::LearningPlan> next_plan_;
    std::optional<Learning::TrialRead> trial_;  // waits or is in flight
    std::optional<Instant> waiting_since_;      // for a moment without due requests
    Instant last_start_ = Instant::min();
};

}  // namespace takt::poll
