// Search for measures: for each kind its steps from the mildest on (remedy.cpp), each planned and proved. If
// the plan reaches the goal, the kind is done. If no kind alone does, pairs of kinds are tried. The number of
// planned variables is limited, and so is the work of the proofs. A plan whose polling alone exceeds the line
// is dropped before it is complete.
#include "takt/plan/measures.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "one_line.hpp"
#include "remedy.hpp"
#include "takt/plan/learning.hpp"
#include "trial_plan.hpp"

namespace takt::plan {
namespace {

using Time = std::optional<Duration>;

constexpr std::size_t kMostPlans = 200;
constexpr std::size_t kMostPlanned = 400'000;  // limit of variables in all trial plans together
// Near full load a proof can take very long, however small the line is: Effort of one trial plan, and of all.
constexpr std::uint64_t kMostWorkOfTrial = 10'000'000;
constexpr std::uint64_t kMostWork = 100'000'000;

constexpr std::array kKinds{MeasureKind::grouping,  MeasureKind::turnarounds, MeasureKind::time_outs,
                            MeasureKind::splitting, MeasureKind::bit_rate,    MeasureKind::periods,
                            MeasureKind::attempts};
constexpr std::array kOfThePlan{MeasureKind::grouping, MeasureKind::time_outs, MeasureKind::splitting};

bool misses(const JobBound& job, Goal goal) {
    if (job.late()) return true;
    if (goal == Goal::with_faults) return job.late_with_fault();
    return goal == Goal::with_dead_device && job.late_with_dead();
}

bool reached(const LineGuarantee& line, Goal goal) {
    return line.feasible && std::none_of(line.jobs.begin(), line.jobs.end(),
                                         [goal](const JobBound& job) { return misses(job, goal); });
}

Time response(const Bound& bound, Goal goal) {
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

/// Projects with one line each, which all searches use in turn, so that a trial plan costs no more than its
/// line.
struct Workbench {
    model::Project project;
    model::Project confirmed;  ///< confirmed_only(project), while the line learns
    std::uint64_t work = 0;    ///< Effort of all proofs
};

class Search {
public:
    /// @param plan, guarantee  of the line as in the project file
    Search(const model::Project& project, const LinePlan& plan, const LineGuarantee& guarantee, Goal goal,
           std::size_t variables, Workbench& bench, const std::function<void()>& on_plan);

    /// @returns false if the search ended at its limit: there may be more measures
    bool run(std::vector<Measure>& found);

private:
    using Steps = std::vector<Step>;
    struct Proof {
        LinePlan plan;
        LineGuarantee guarantee;
    };

    void restore();
    /// The line as in the project file, changed by these steps.
    void start_from(const Steps& base);
    /// The plan of the changed line, if it reaches the goal.
    std::optional<Proof> reaching_plan();
    [[nodiscard]] LineGuarantee prove(const LinePlan& plan);
    /// The steps of one kind from these on, which start_from() has just made.
    [[nodiscard]] Steps steps_from(const Steps& base, MeasureKind kind) const;
    [[nodiscard]] bool exhausted() {
        const bool now =
            plans_ >= kMostPlans || plans_ * variables_ > kMostPlanned || bench_.work > kMostWork;
        exhausted_ = exhausted_ || now;
        return now;
    }
    bool try_kind(MeasureKind kind, const Steps& base, std::vector<MeasureKind> kinds,
                  std::vector<Measure>& found);
    void try_pairs(std::vector<Measure>& found);
    void choose_subject();
    [[nodiscard]] Figures figures(const LinePlan& plan, const LineGuarantee& guarantee) const;
    void add(const Steps& made, const Proof& proof, std::vector<MeasureKind> kinds,
             std::vector<Measure>& found) const;

    const model::Project& project_;
    const LinePlan& plan_;  // of the line as in the project file, like its guarantee
    const LineGuarantee& guarantee_;
    Goal goal_;
    std::size_t line_;
    std::size_t variables_;  // of the project, which the limit counts
    std::size_t plans_ = 1;  // with the plan of the line as in the project file
    bool exhausted_ = false;
    Workbench& bench_;
    Editor editor_;
    const std::function<void()>& on_plan_;
    Subject subject_;
    Figures before_;
};

Search::Search(const model::Project& project, const LinePlan& plan, const LineGuarantee& guarantee, Goal goal,
               std::size_t variables, Workbench& bench, const std::function<void()>& on_plan)
    : project_(project),
      plan_(plan),
      guarantee_(guarantee),
      goal_(goal),
      line_(guarantee.line),
      variables_(variables),
      bench_(bench),
      editor_(bench.project, 0, line_),
      on_plan_(on_plan) {
    restore();
}

void Search::restore() {
    bench_.project.lines[0] = project_.lines[line_];
    bench_.project.derive_timeouts = project_.derive_timeouts;
    bench_.project.backoff = project_.backoff;
    editor_.forget_changes();
}

void Search::start_from(const Steps& base) {
    if (!editor_.changes().empty()) restore();
    for (const Step& step : base) step(editor_);
}

std::optional<Search::Proof> Search::reaching_plan() {
    ++plans_;
    auto plan = trial_plan(bench_.project, 0);
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

LineGuarantee Search::prove(const LinePlan& plan) {
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

Search::Steps Search::steps_from(const Steps& base, MeasureKind kind) const {
    const model::Project& own = bench_.project;
    if (base.empty() || !needs_plan(kind)) return steps(kind, own.lines[0], own.profile, plan_);
    return steps(kind, own.lines[0], own.profile, plan_line(own, 0));
}

void Search::choose_subject() {
    Duration worst = Duration::min();
    for (const JobBound& job : guarantee_.jobs) {
        if (!misses(job, goal_)) continue;
        const Time longest = response(job.bound, goal_);
        const Duration over = longest ? *longest - *job.bound.deadline : Duration::max();
        if (over <= worst) continue;
        worst = over;
        const Request& request = plan_.requests[job.request];
        subject_ = {request.device, request.variables.front(), job.cause};
    }
    before_ = figures(plan_, guarantee_);
}

Figures Search::figures(const LinePlan& plan, const LineGuarantee& guarantee) const {
    Figures worst{.response = Duration::zero()};
    for (const JobBound& job : guarantee.jobs) {
        const Request& request = plan.requests[job.request];
        const auto& variables = request.variables;
        if (job.cause != subject_.cause || request.device != subject_.device ||
            std::find(variables.begin(), variables.end(), subject_.variable) == variables.end())
            continue;
        const Time longest = response(job.bound, goal_);
        worst.response = worst.response && longest ? Time(std::max(*worst.response, *longest)) : std::nullopt;
        worst.deadline = job.bound.deadline.value_or(Duration::zero());
    }
    return worst;
}

void Search::add(const Steps& made, const Proof& proof, std::vector<MeasureKind> kinds,
                 std::vector<Measure>& found) const {
    const Figures after = figures(proof.plan, proof.guarantee);
    found.push_back(
        {.kinds = std::move(kinds),
         .line = line_,
         .goal = goal_,
         .changes = editor_.changes(),
         .apply =
             [made, line = line_](model::Project& project) {
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

bool Search::try_kind(MeasureKind kind, const Steps& base, std::vector<MeasureKind> kinds,
                      std::vector<Measure>& found) {
    kinds.push_back(kind);
    if (exhausted()) return false;
    start_from(base);
    for (const Step& step : steps_from(base, kind)) {
        if (exhausted()) return false;
        start_from(base);
        const std::size_t before = editor_.changes().size();
        step(editor_);
        if (editor_.changes().size() == before) continue;
        const auto proof = reaching_plan();
        if (!proof) continue;
        Steps made = base;
        made.push_back(step);
        add(made, *proof, std::move(kinds), found);
        return true;
    }
    return false;
}

// The mildest and the furthest step of the first kind are the base plans for the second kind.
void Search::try_pairs(std::vector<Measure>& found) {
    for (std::size_t a = 0; a < kKinds.size(); ++a) {
        start_from({});
        const auto first = steps_from({}, kKinds[a]);
        for (std::size_t i = 0; i < first.size(); i += std::max<std::size_t>(1, first.size() - 1)) {
            if (exhausted()) return;
            const Steps base{first[i]};
            start_from(base);
            if (editor_.changes().empty()) continue;
            for (std::size_t b = a + 1; b < kKinds.size(); ++b)
                if (try_kind(kKinds[b], base, {kKinds[a]}, found)) return;
        }
    }
}

bool Search::run(std::vector<Measure>& found) {
    choose_subject();
    bool any = false;
    for (const MeasureKind kind : kKinds)
        if (try_kind(kind, {}, {}, found)) any = true;
    if (!any) try_pairs(found);
    return !exhausted_;
}

}  // namespace

std::string_view name(MeasureKind kind) {
    switch (kind) {
        case MeasureKind::grouping: return "grouping";
        case MeasureKind::turnarounds: return "turnarounds";
        case MeasureKind::time_outs: return "time_outs";
        case MeasureKind::splitting: return "splitting";
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
    std::size_t variables = 1;
    for (const auto& line : project.lines)
        for (const auto& device : line.devices) variables += device.variables.size();
    std::size_t searched = 0;
    const std::function<void()> report = [&] {
        if (progress) progress(searched, guarantees.size());
    };
    Workbench bench{with_one_line(project, {}), with_one_line(project, {}), 0};
    MeasureSearch made;
    for (const LineGuarantee& line : guarantees) {
        if (const auto goal = missed_goal(project, line, dead_device)) {
            Search search(project, plan.lines[line.line], line, *goal, variables, bench, report);
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
