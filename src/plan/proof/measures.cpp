// Search for measures: for each kind the mildest step (remedy.cpp) whose plan reaches the goal, each planned
// and proved. Of ordered steps the furthest one is tried first: if it fails, all do; else the mildest one is
// found by bisection, which begins beside the step that sufficed on the previous line, because lines are
// often alike. If no kind alone suffices, pairs of kinds are tried. The number of planned variables is
// limited, and so is the work of the proofs. A plan whose polling alone exceeds the line is dropped before it
// is complete.
#include "takt/plan/measures.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <utility>

#include "proof/remedy.hpp"
#include "proof/trial_plan.hpp"
#include "requests/one_line.hpp"
#include "takt/plan/learning.hpp"
#include "takt/plan/shares.hpp"

namespace takt::plan {
namespace {

using Time = std::optional<Duration>;

constexpr std::size_t kMostPlans = 200;
constexpr std::size_t kMostPlanned = 400'000;  // limit of variables in all trial plans together
constexpr std::size_t kCopiesPerPlan = 4;      // a copy of a line takes a fraction of the time of its plan
constexpr std::size_t kMostLate = 8;           // requests whose periods are lengthened alone
// Near full load a proof can take very long, however small the line is: Effort of one trial plan, and of all.
constexpr std::uint64_t kMostWorkOfTrial = 10'000'000;
constexpr std::uint64_t kMostWorkOfSearch = 100'000'000;

// Where the tasks of a line exceed it, the load is the problem. Else something blocks a more urgent request,
// and what leaves the periods alone comes first.
constexpr std::array kAgainstLoad{
    MeasureKind::grouping, MeasureKind::turnarounds, MeasureKind::periods,   MeasureKind::relay_interval,
    MeasureKind::bit_rate, MeasureKind::time_outs,   MeasureKind::splitting, MeasureKind::attempts};
constexpr std::array kAgainstBlocking{
    MeasureKind::grouping,       MeasureKind::turnarounds, MeasureKind::time_outs, MeasureKind::splitting,
    MeasureKind::relay_interval, MeasureKind::bit_rate,    MeasureKind::periods,   MeasureKind::attempts};
constexpr std::array kOfThePlan{MeasureKind::grouping, MeasureKind::time_outs, MeasureKind::splitting};

bool misses_goal(const JobBound& job, Goal goal) {
    if (job.late()) return true;
    if (goal == Goal::with_faults) return job.late_with_fault();
    return goal == Goal::with_dead_device && job.late_with_dead();
}

bool reached(const LineGuarantee& line, Goal goal) {
    return line.feasible && std::none_of(line.jobs.begin(), line.jobs.end(),
                                         [goal](const JobBound& job) { return misses_goal(job, goal); });
}

Time response_for(const Bound& bound, Goal goal) {
    if (goal == Goal::with_faults) return bound.response_with_fault;
    return goal == Goal::with_dead_device ? bound.response_with_dead : bound.response;
}

std::optional<Goal> missed_goal(const model::Project& project, const LineGuarantee& line, bool dead_device) {
    if (!reached(line, Goal::sound)) return Goal::sound;
    if (project.faults_set && !reached(line, Goal::with_faults)) return Goal::with_faults;
    if (dead_device && !reached(line, Goal::with_dead_device)) return Goal::with_dead_device;
    return std::nullopt;
}

/// A variable by its position, which no measure changes.
struct Subject {
    std::size_t device = 0;
    std::size_t variable = 0;
    Cause cause = Cause::period;
};

/// The response to one variable, and its deadline.
struct Figures {
    Time response;
    Duration deadline{};
};

/// A ladder of a kind, by its position.
using LadderKey = std::pair<MeasureKind, std::size_t>;

/// Projects with one line each, which all searches use in turn, so that a trial plan costs no more than its
/// line.
struct Workbench {
    model::Project project;
    model::Project confirmed;                     ///< confirmed_only(project), while the line learns
    std::map<LadderKey, std::size_t> sufficient;  ///< the step of the last line on which the ladder sufficed
    std::size_t planned = 0;                      ///< variables in all trial plans
    std::uint64_t work = 0;                       ///< Effort of all proofs
};

/// The limits of the search of one line, as totals of the workbench.
struct Limits {
    std::size_t planned = 0;
    std::uint64_t work = 0;
};

class LineMeasureSearch {
public:
    /// @param plan, guarantee  of the line as in the project file
    LineMeasureSearch(const model::Project& project, const LinePlan& plan, const LineGuarantee& guarantee,
                      Goal goal, const Limits& limits, Workbench& bench,
                      const std::function<void()>& on_plan);

    /// @returns false if the search ended at its limit: there may be more measures
    bool run(std::vector<Measure>& found);

private:
    using Steps = std::vector<Step>;
    struct Proof {
        LinePlan plan;
        LineGuarantee guarantee;
    };
    /// A step of a ladder that suffices.
    struct Sufficient {
        std::size_t step = 0;
        Proof proof;
    };

    void restore();
    /// The line as in the project file, changed by these steps.
    void start_from(const Steps& base, bool recording = false);
    /// The plan of the line after these steps and this one, if it reaches the goal.
    std::optional<Proof> reaches(const Steps& base, const Step& step);
    std::optional<Proof> reaching_plan();
    [[nodiscard]] LineGuarantee prove(const LinePlan& plan);
    [[nodiscard]] std::vector<MeasureKind> kinds() const;
    [[nodiscard]] std::vector<Members> late_requests() const;
    /// The ladders of one kind after these steps, which start_from() has just made.
    [[nodiscard]] std::vector<Ladder> ladders_from(const Steps& base, MeasureKind kind) const;
    [[nodiscard]] bool exhausted() {
        const bool now =
            plans_ >= kMostPlans || bench_.planned > limits_.planned || bench_.work > limits_.work;
        exhausted_ = exhausted_ || now;
        return now;
    }
    /// The mildest step that suffices.
    std::optional<Sufficient> climb(const Ladder& ladder, const Steps& base, const LadderKey& key);
    std::optional<Sufficient> climb_one_by_one(const Ladder& ladder, const Steps& base);
    [[nodiscard]] bool frees_too_little(const Ladder& ladder) const;
    bool try_kind(MeasureKind kind, const Steps& base, std::vector<MeasureKind> kinds,
                  std::vector<Measure>& found);
    void try_pairs(std::vector<Measure>& found);
    void try_grouping_with_turnarounds(std::vector<Measure>& found);
    void choose_subject();
    [[nodiscard]] Figures figures(const LinePlan& plan, const LineGuarantee& guarantee) const;
    void add(Steps made, const Proof& proof, std::vector<MeasureKind> kinds, double largest_share,
             std::vector<Measure>& found);

    const model::Project& project_;
    const LinePlan& plan_;  // of the line as in the project file, like its guarantee
    const LineGuarantee& guarantee_;
    Goal goal_;
    std::size_t line_;
    Limits limits_;
    std::size_t variables_ = 0;  // of the line
    std::size_t plans_ = 0;
    bool exhausted_ = false;
    Workbench& bench_;
    Editor editor_;
    const std::function<void()>& on_plan_;
    Subject subject_;
    Figures before_;
};

LineMeasureSearch::LineMeasureSearch(const model::Project& project, const LinePlan& plan,
                                     const LineGuarantee& guarantee, Goal goal, const Limits& limits,
                                     Workbench& bench, const std::function<void()>& on_plan)
    : project_(project),
      plan_(plan),
      guarantee_(guarantee),
      goal_(goal),
      line_(guarantee.line),
      limits_(limits),
      bench_(bench),
      editor_(bench.project, 0, line_),
      on_plan_(on_plan) {
    for (const auto& device : project.lines[line_].devices) variables_ += device.variables.size();
    restore();
}

void LineMeasureSearch::restore() {
    bench_.project.lines[0] = project_.lines[line_];
    bench_.project.derive_timeouts = project_.derive_timeouts;
    bench_.project.backoff = project_.backoff;
    bench_.planned += variables_ / kCopiesPerPlan;
    editor_.restart(false);
}

void LineMeasureSearch::start_from(const Steps& base, bool recording) {
    if (editor_.count() > 0) restore();
    editor_.restart(recording);
    for (const Step& step : base) step(editor_);
}

std::optional<LineMeasureSearch::Proof> LineMeasureSearch::reaches(const Steps& base, const Step& step) {
    if (exhausted()) return std::nullopt;
    start_from(base);
    const std::size_t before = editor_.count();
    step(editor_);
    return editor_.count() > before ? reaching_plan() : std::nullopt;
}

std::optional<LineMeasureSearch::Proof> LineMeasureSearch::reaching_plan() {
    ++plans_;
    auto plan = trial_plan(bench_.project, 0, bench_.planned);
    std::optional<Proof> proof;
    if (plan) {
        auto guarantee = prove(*plan);
        if (reached(guarantee, goal_))
            proof = Proof{*std::move(plan), std::move(guarantee)};
        else if (!guarantee.exact)
            exhausted_ = true;  // exact bounds might reach it
    }
    on_plan_();
    return proof;
}

LineGuarantee LineMeasureSearch::prove(const LinePlan& plan) {
    const model::Project& own = bench_.project;
    if (learns(own.lines[0])) {
        bench_.confirmed.lines[0] = confirmed_only(own.lines[0]);
        bench_.confirmed.derive_timeouts = own.derive_timeouts;
        bench_.confirmed.backoff = own.backoff;
    }
    const auto scope = goal_ == Goal::sound ? Scope::without_failures : Scope::everything;
    Effort effort{.most = kMostWorkOfTrial};
    auto guarantee = guarantee_line(own, bench_.confirmed, plan, {}, scope, &effort);
    bench_.work += effort.spent;
    return guarantee;
}

std::vector<MeasureKind> LineMeasureSearch::kinds() const {
    const bool overloaded = guarantee_.utilization > 1;
    std::vector<MeasureKind> kinds(kAgainstBlocking.begin(), kAgainstBlocking.end());
    if (overloaded) kinds.assign(kAgainstLoad.begin(), kAgainstLoad.end());
    const auto largest = largest_shares(plan_, 1);
    if (overloaded && !largest.empty() && guarantee_.relayed_share > largest.front().share)
        std::swap(*std::ranges::find(kinds, MeasureKind::periods),
                  *std::ranges::find(kinds, MeasureKind::relay_interval));
    if (goal_ != Goal::sound) return kinds;
    // Without failures they cost nothing, except that a relayed request counts as a failed attempt.
    std::erase(kinds, MeasureKind::attempts);
    if (!project_.lines[line_].relayed) std::erase(kinds, MeasureKind::time_outs);
    return kinds;
}

std::vector<Members> LineMeasureSearch::late_requests() const {
    std::vector<Members> late;
    for (const JobBound& job : guarantee_.jobs) {
        if (job.cause != Cause::period || !misses_goal(job, goal_)) continue;
        if (late.size() == kMostLate) return {};
        const Request& request = plan_.requests[job.request];
        late.push_back({request.device, request.variables});
    }
    return late;
}

std::vector<Ladder> LineMeasureSearch::ladders_from(const Steps& base, MeasureKind kind) const {
    const model::Project& own = bench_.project;
    const bool overloaded = guarantee_.utilization > 1;
    if (base.empty()) return ladders(kind, own.lines[0], own.profile, {plan_, overloaded, late_requests()});
    if (!needs_plan(kind)) return ladders(kind, own.lines[0], own.profile, {plan_, overloaded, {}});
    bench_.planned += variables_;
    return ladders(kind, own.lines[0], own.profile, {plan_line(own, 0), overloaded, {}});
}

void LineMeasureSearch::choose_subject() {
    Duration worst = Duration::min();
    for (const JobBound& job : guarantee_.jobs) {
        if (!misses_goal(job, goal_)) continue;
        const Time longest = response_for(job.bound, goal_);
        const Duration over = longest ? *longest - *job.bound.deadline : Duration::max();
        if (over <= worst) continue;
        worst = over;
        const Request& request = plan_.requests[job.request];
        subject_ = {request.device, request.variables.front(), job.cause};
    }
    before_ = figures(plan_, guarantee_);
}

Figures LineMeasureSearch::figures(const LinePlan& plan, const LineGuarantee& guarantee) const {
    Figures worst{.response = Duration::zero()};
    for (const JobBound& job : guarantee.jobs) {
        const Request& request = plan.requests[job.request];
        const auto& variables = request.variables;
        if (job.cause != subject_.cause || request.device != subject_.device ||
            std::find(variables.begin(), variables.end(), subject_.variable) == variables.end())
            continue;
        const Time longest = response_for(job.bound, goal_);
        worst.response = worst.response && longest ? Time(std::max(*worst.response, *longest)) : std::nullopt;
        worst.deadline = job.bound.deadline.value_or(Duration::zero());
    }
    return worst;
}

void LineMeasureSearch::add(Steps made, const Proof& proof, std::vector<MeasureKind> kinds,
                            double largest_share, std::vector<Measure>& found) {
    const Figures after = figures(proof.plan, proof.guarantee);
    start_from(made, true);
    found.push_back(
        {.kinds = std::move(kinds),
         .largest_share = largest_share,
         .line = line_,
         .goal = goal_,
         .changes = editor_.changes(),
         .apply =
             [made = std::move(made), line = line_](model::Project& project) {
                 Editor editor(project, line, line);
                 for (const Step& step : made) step(editor);
             },
         .variable = project_.lines[line_].devices[subject_.device].variables[subject_.variable].name,
         .before = before_.response,
         .after = after.response,
         .deadline = after.deadline,
         .utilization_before = guarantee_.utilization,
         .utilization_after = proof.guarantee.utilization});
}

std::optional<LineMeasureSearch::Sufficient> LineMeasureSearch::climb_one_by_one(const Ladder& ladder,
                                                                                 const Steps& base) {
    for (std::size_t i = 0; i < ladder.steps.size(); ++i)
        if (auto proof = reaches(base, ladder.steps[i])) return Sufficient{i, *std::move(proof)};
    return std::nullopt;
}

std::optional<LineMeasureSearch::Sufficient> LineMeasureSearch::climb(const Ladder& ladder, const Steps& base,
                                                                      const LadderKey& key) {
    if (!ladder.ordered) return climb_one_by_one(ladder, base);
    std::optional<Sufficient> best;
    std::size_t low = 0;
    std::size_t high = ladder.steps.size();  // the steps from here on suffice
    const auto test = [&](std::size_t step) {
        auto proof = reaches(base, ladder.steps[step]);
        if (!proof) {
            low = step + 1;
        } else {
            high = step;
            best = Sufficient{step, *std::move(proof)};
        }
    };
    const auto before = bench_.sufficient.find(key);
    if (before != bench_.sufficient.end() && before->second < high) {
        test(before->second);
        if (best && low < high) test(high - 1);
    }
    if (!best && low < high) test(high - 1);
    if (!best) return std::nullopt;
    while (low < high) test(low + (high - low) / 2);
    bench_.sufficient.insert_or_assign(key, best->step);
    return best;
}

// The line stays overloaded. In the worst case a share is larger than estimated, about as much as the load
// is.
bool LineMeasureSearch::frees_too_little(const Ladder& ladder) const {
    constexpr double kPeriodRounding = 0.05;  // periods are lengthened to round numbers, up
    if (!ladder.relief || plan_.utilization <= 0) return false;
    const double left = 1 - *ladder.relief / plan_.utilization;
    return guarantee_.utilization * left > 1 + kPeriodRounding;
}

bool LineMeasureSearch::try_kind(MeasureKind kind, const Steps& base, std::vector<MeasureKind> kinds,
                                 std::vector<Measure>& found) {
    kinds.push_back(kind);
    if (exhausted()) return false;
    start_from(base);
    const auto all = ladders_from(base, kind);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (base.empty() && frees_too_little(all[i])) continue;
        const auto sufficient = climb(all[i], base, {kind, i});
        if (!sufficient) continue;
        Steps made = base;
        made.push_back(all[i].steps[sufficient->step]);
        add(std::move(made), sufficient->proof, std::move(kinds), all[i].largest_share, found);
        return true;
    }
    return false;
}

// The mildest and the furthest step of the first kind are the base plans for the second kind.
void LineMeasureSearch::try_pairs(std::vector<Measure>& found) {
    const auto kinds = this->kinds();
    for (std::size_t a = 0; a < kinds.size(); ++a) {
        start_from({});
        Steps bases;
        for (const Ladder& ladder : ladders_from({}, kinds[a]))
            bases.insert(bases.end(), ladder.steps.begin(), ladder.steps.end());
        if (bases.size() > 2) bases = {bases.front(), bases.back()};
        for (const Step& first : bases) {
            if (exhausted()) return;
            const Steps base{first};
            start_from(base);
            if (editor_.count() == 0) continue;
            for (std::size_t b = a + 1; b < kinds.size(); ++b)
                if (try_kind(kinds[b], base, {kinds[a]}, found)) return;
        }
    }
}

// Both cost nothing, so they come first together where neither alone suffices.
void LineMeasureSearch::try_grouping_with_turnarounds(std::vector<Measure>& found) {
    start_from({});
    for (const Ladder& ladder : ladders_from({}, MeasureKind::grouping))
        for (const Step& step : ladder.steps)
            if (try_kind(MeasureKind::turnarounds, {step}, {MeasureKind::grouping}, found)) return;
}

bool LineMeasureSearch::run(std::vector<Measure>& found) {
    choose_subject();
    const auto before = static_cast<std::ptrdiff_t>(found.size());
    for (const MeasureKind kind : kinds()) try_kind(kind, {}, {}, found);
    const auto own = [&] { return std::span(found).subspan(static_cast<std::size_t>(before)); };
    if (own().empty()) {
        try_pairs(found);
    } else if (const auto first = own().front().kinds.front();
               first != MeasureKind::grouping && first != MeasureKind::turnarounds) {
        const auto single = found.size();
        try_grouping_with_turnarounds(found);
        if (found.size() > single) std::rotate(found.begin() + before, found.end() - 1, found.end());
    }
    return !exhausted_;
}

}  // namespace

std::string_view name(MeasureKind kind) {
    switch (kind) {
        case MeasureKind::grouping: return "grouping";
        case MeasureKind::turnarounds: return "turnarounds";
        case MeasureKind::time_outs: return "time_outs";
        case MeasureKind::splitting: return "splitting";
        case MeasureKind::relay_interval: return "relay_interval";
        case MeasureKind::bit_rate: return "bit_rate";
        case MeasureKind::periods: return "periods";
        case MeasureKind::attempts: break;
    }
    return "attempts";
}

bool Measure::only_plan() const {
    return std::ranges::all_of(
        kinds, [](MeasureKind kind) { return std::ranges::find(kOfThePlan, kind) != kOfThePlan.end(); });
}

MeasureSearch measures(const model::Project& project, const Plan& plan,
                       const std::vector<LineGuarantee>& guarantees, bool dead_device,
                       const Progress& progress) {
    std::vector<std::optional<Goal>> goals;
    for (const LineGuarantee& line : guarantees) goals.push_back(missed_goal(project, line, dead_device));
    std::size_t searched = 0;
    auto left = static_cast<std::size_t>(
        std::ranges::count_if(goals, [](const auto& goal) { return goal.has_value(); }));
    const std::function<void()> report = [&] {
        if (progress) progress(searched, guarantees.size());
    };
    Workbench bench{with_one_line(project, {}), with_one_line(project, {}), {}};
    MeasureSearch made;
    for (const LineGuarantee& line : guarantees) {
        if (const auto goal = goals[searched]) {
            const Limits limits{
                bench.planned + (kMostPlanned - std::min(bench.planned, kMostPlanned)) / left,
                bench.work + (kMostWorkOfSearch - std::min(bench.work, kMostWorkOfSearch)) / left};
            --left;
            LineMeasureSearch search(project, plan.lines[line.line], line, *goal, limits, bench, report);
            if (!search.run(made.found)) made.unfinished.push_back(line.line);
        }
        ++searched;
        report();
    }
    return made;
}

std::span<const Measure> measures_of(std::span<const Measure> measures, std::size_t line) {
    const auto own = std::ranges::equal_range(measures, line, {}, &Measure::line);
    return {own.begin(), own.end()};
}

}  // namespace takt::plan
