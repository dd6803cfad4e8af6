// Response times are bounded per task (response.cpp) and assigned to requests. The age of a value is bounded
// by the longest interval between two of its reads + the response of the slowest request that reads it.
#include "takt/plan/guarantee.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <utility>

#include "cost/transaction_cost.hpp"
#include "proof/line_tasks.hpp"
#include "takt/plan/learning.hpp"
#include "takt/plan/shares.hpp"
#include "timing/step_check.hpp"
#include "timing/streams.hpp"

namespace takt::plan {
namespace {

using Time = std::optional<Duration>;

Time duration(const std::optional<Microseconds>& time) {
    return time ? Time(std::chrono::microseconds(*time)) : std::nullopt;
}

/// The later of two bounds. No bound is the latest.
Time later(const Time& a, const Time& b) {
    return a && b ? Time(std::max(*a, *b)) : std::nullopt;
}

// Effort of all lines; beyond it, of each further one.
constexpr std::uint64_t kMostWorkOfLines = 150'000'000;
constexpr std::uint64_t kLeastWorkOfLine = 50'000;

constexpr std::array kResponses{&Bound::response, &Bound::response_with_fault, &Bound::response_with_dead};

FaultRate fault_rate(const model::Faults& faults) {
    const auto every = std::chrono::floor<std::chrono::microseconds>(faults.every).count();
    return {.burst = faults.burst, .every = std::max<Microseconds>(every, 1)};
}

/// The three analyses of a line, for one request at a time or several in flight.
struct Analyses {
    const LineTasks& line;
    Effort* effort;

    [[nodiscard]] Responses plain() const {
        if (line.connection) return parallel_response_times(line.tasks, *line.connection, effort);
        return responses_with_holds(
            line, [&](const std::vector<Task>& tasks) { return response_times(tasks, effort); });
    }
    [[nodiscard]] Responses with_faults(const FaultRate& faults) const {
        if (line.connection)
            return parallel_response_times_with_faults(line.tasks, *line.connection, faults, effort);
        return responses_with_holds(line, [&](const std::vector<Task>& tasks) {
            return response_times_with_faults(tasks, faults, effort);
        });
    }
    [[nodiscard]] Responses with_dead_device() const {
        if (line.connection)
            return parallel_response_times_with_dead_device(line.tasks, *line.connection, effort);
        return responses_with_holds(line, [&](const std::vector<Task>& tasks) {
            return response_times_with_dead_device(tasks, effort);
        });
    }
};

std::vector<JobBound> bounds_of(const model::Project& project, const LineTasks& line, Scope scope,
                                Effort* effort) {
    const Responses unknown(line.tasks.size());
    const bool all = scope == Scope::everything;
    const Analyses analyses{line, effort};
    const auto plain = analyses.plain();
    const auto with_faults = !all                        ? unknown
                             : project.faults.burst == 0 ? plain
                                                         : analyses.with_faults(fault_rate(project.faults));
    const auto with_dead = all ? analyses.with_dead_device() : unknown;
    std::vector<JobBound> bounds;
    for (const LineJob& job : line.jobs) {
        JobBound made{.request = job.request, .cause = job.cause};
        made.bound.transaction = std::chrono::microseconds(job.transaction);
        made.bound.failure = std::chrono::microseconds(job.failure);
        made.bound.deadline = duration(job.deadline);
        made.limited = job.task && line.tasks[*job.task].period > 0;
        if (made.limited) {
            made.bound.response = duration(plain[*job.task]);
            made.bound.response_with_fault = duration(with_faults[*job.task]);
            made.bound.response_with_dead = duration(with_dead[*job.task]);
        }
        bounds.push_back(made);
    }
    return bounds;
}

// A write that only commands cause has a cost, and no job with bounds.
void set_command_costs(const model::Project& project, const LinePlan& plan, LineGuarantee& made) {
    const TransactionCosts costs(project, project.lines[plan.line]);
    for (std::size_t i = 0; i < plan.requests.size(); ++i) {
        Bound& bound = made.requests[i];
        if (bound.transaction > Duration::zero() || !plan.requests[i].write) continue;
        for (const TransactionCost& cost : costs.of_write(plan.requests[i])) {
            bound.transaction += std::chrono::microseconds(cost.transaction);
            bound.failure = std::max<Duration>(bound.failure, std::chrono::microseconds(cost.failure));
        }
    }
}

// The bound of a request is that of its polling, or else its largest one.
void set_requests(const model::Project& project, const LinePlan& plan, LineGuarantee& line) {
    const std::size_t count = plan.requests.size();
    std::vector<const JobBound*> chosen(count, nullptr);
    for (const JobBound& job : line.jobs) {
        const JobBound*& known = chosen[job.request];
        if (known && known->cause == Cause::period && known->limited) continue;
        if (!known || later(known->bound.response, job.bound.response) == job.bound.response) known = &job;
    }
    line.requests.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        if (chosen[i]) line.requests[i] = chosen[i]->bound;
    set_command_costs(project, plan, line);
}

using Ages = std::vector<std::vector<Time>>;

/// @param response  of a job
template <class Response>
Ages ages_of(const LinePlan& plan, const LineGuarantee& made, const Ages& distances,
             const Response& response) {
    Ages ages = distances;
    for (const JobBound& job : made.jobs) {
        if (job.cause != Cause::period || !job.limited) continue;
        const Request& request = plan.requests[job.request];
        const Time longest = response(job.bound);
        for (const std::size_t v : request.variables) {
            Time& age = ages[request.device][v];
            const Time& distance = distances[request.device][v];
            if (!longest || !distance)
                age.reset();
            else if (age)
                age = std::max(*age, *distance + *longest);
        }
    }
    return ages;
}

Time response_with_failures(const Bound& bound) {
    const Time faulty = later(bound.response, bound.response_with_fault);
    return faulty && bound.response_with_dead ? later(faulty, bound.response_with_dead) : faulty;
}

void set_ages(const model::Line& line, const LinePlan& plan, LineGuarantee& made) {
    const auto distances = read_distances(line, plan);
    made.ages = ages_of(plan, made, distances, [](const Bound& bound) { return bound.response; });
    made.ages_with_failures = ages_of(plan, made, distances, response_with_failures);
}

void set_request_ages(const LinePlan& plan, LineGuarantee& made) {
    for (std::size_t i = 0; i < plan.requests.size(); ++i) {
        const Request& request = plan.requests[i];
        if (!is_periodic(request) || request.variables.empty()) continue;
        Time age = Duration::zero();
        for (const std::size_t v : request.variables) age = later(age, made.ages[request.device][v]);
        made.requests[i].age = age;
    }
}

double share_of_task(const LineTasks& line, const std::optional<std::size_t>& task) {
    return task ? utilization(std::span(line.tasks).subspan(*task, 1)) / line.in_flight() : 0;
}

void set_verdict(LineGuarantee& made) {
    made.feasible = std::none_of(made.jobs.begin(), made.jobs.end(), std::mem_fn(&JobBound::late));
    made.unlimited =
        static_cast<std::size_t>(std::count_if(made.jobs.begin(), made.jobs.end(), [](const JobBound& job) {
            return !job.limited && job.cause != Cause::period;
        }));
}

// gaps: learn
// ------------------------------------------------------------------------------------------------

Bound latest_of(const Bound& a, const Bound& b) {
    Bound bound = a;
    for (const auto response : kResponses) bound.*response = later(a.*response, b.*response);
    return bound;
}

bool exceeds(const Time& response, const Time& deadline) {
    return deadline && (!response || *response > *deadline);
}

/// A request is as slow as its values are in the other plan. A value with more time there does not make
/// values late that are read with it here; a value that is late there does.
void worsen_bound(Bound& bound, const Bound& other) {
    for (const auto response : kResponses) {
        const bool has_more_time = bound.deadline && other.deadline > bound.deadline;
        if (has_more_time && !exceeds(other.*response, other.deadline)) continue;
        bound.*response = later(bound.*response, other.*response);
    }
}

/// The bounds of each variable in another plan, by device and cause. With several requests, the latest.
class Fallback {
public:
    Fallback(const model::Line& line, const LinePlan& plan, const LineGuarantee& guarantee);
    void worsen(const LinePlan& plan, LineGuarantee& made) const;

private:
    [[nodiscard]] const std::vector<std::optional<Bound>>& of(Cause cause, std::size_t device) const {
        return worst_[static_cast<std::size_t>(cause)][device];
    }

    const LineGuarantee& guarantee_;
    std::array<std::vector<std::vector<std::optional<Bound>>>, 3> worst_;
};

Fallback::Fallback(const model::Line& line, const LinePlan& plan, const LineGuarantee& guarantee)
    : guarantee_(guarantee) {
    for (auto& worst : worst_)
        for (const auto& device : line.devices) worst.emplace_back(device.variables.size());
    for (const JobBound& job : guarantee.jobs) {
        const Request& request = plan.requests[job.request];
        for (const std::size_t v : request.variables) {
            auto& known = worst_[static_cast<std::size_t>(job.cause)][request.device][v];
            known = known ? latest_of(*known, job.bound) : job.bound;
        }
    }
}

void Fallback::worsen(const LinePlan& plan, LineGuarantee& made) const {
    for (JobBound& job : made.jobs) {
        const Request& request = plan.requests[job.request];
        for (const std::size_t v : request.variables)
            if (const auto& other = of(job.cause, request.device)[v]) worsen_bound(job.bound, *other);
    }
    for (std::size_t d = 0; d < made.ages.size(); ++d)
        for (std::size_t v = 0; v < made.ages[d].size(); ++v)
            made.ages[d][v] = later(made.ages[d][v], guarantee_.ages[d][v]);
    for (std::size_t d = 0; d < made.ages_with_failures.size(); ++d)
        for (std::size_t v = 0; v < made.ages_with_failures[d].size(); ++v)
            made.ages_with_failures[d][v] =
                later(made.ages_with_failures[d][v], guarantee_.ages_with_failures[d][v]);
    made.utilization = std::max(made.utilization, guarantee_.utilization);
    made.exact = made.exact && guarantee_.exact;
    made.feasible_edf = made.feasible_edf && guarantee_.feasible_edf;
}

}  // namespace

std::string_view name(ResponseSource source) {
    constexpr std::array<std::string_view, 3> kNames{"written", "measured", "time_out"};
    return kNames[static_cast<std::size_t>(source)];
}

ResponseSource response_source(const model::Line& line) {
    auto worst = ResponseSource::written;
    for (const auto& device : line.devices) {
        if (!device.expected_turnaround()) return ResponseSource::time_out;
        if (device.measured_exchanges() > 0) worst = ResponseSource::measured;
    }
    return worst;
}

LineGuarantee guarantee_line(const model::Project& project, const LinePlan& plan, Scope scope,
                             Effort* effort) {
    const LineTasks line = line_tasks(project, plan);
    LineGuarantee made{.line = plan.line};
    Effort own;
    if (!effort) effort = &own;
    made.jobs = bounds_of(project, line, scope, effort);
    made.exact = !effort->exhausted;
    set_requests(project, plan, made);
    if (scope == Scope::everything) {
        set_ages(project.lines[plan.line], plan, made);
        set_request_ages(plan, made);
    }
    made.in_flight = line.in_flight();
    made.utilization = utilization(line.tasks) / line.in_flight();
    if (is_saturated(plan)) made.utilization = std::max(1.0, made.utilization);
    made.relayed_share = share_of_task(line, line.relayed);
    made.client_share = share_of_task(line, line.clients);
    set_verdict(made);
    // Several in flight: the second opinion would take one after the other.
    made.feasible_edf =
        line.connection ? made.feasible : scope == Scope::everything && feasible_edf(tasks_and_holds(line));
    return made;
}

LineGuarantee guarantee_line(const model::Project& project, const model::Project& confirmed,
                             const LinePlan& plan, const Options& options, Scope scope, Effort* effort) {
    LineGuarantee made = guarantee_line(project, plan, scope, effort);
    if (!learns(project.lines[plan.line])) return made;
    const LinePlan fallback = plan_line(confirmed, plan.line, options);
    const auto other = guarantee_line(confirmed, fallback, scope, effort);
    Fallback(confirmed.lines[plan.line], fallback, other).worsen(plan, made);
    set_requests(project, plan, made);
    if (scope == Scope::everything) set_request_ages(plan, made);
    set_verdict(made);
    made.feasible = made.feasible && other.feasible;
    return made;
}

std::vector<LineGuarantee> guarantee(const model::Project& project, const Plan& plan, const Options& options,
                                     Scope scope) {
    const auto confirmed = learns(project) ? std::optional(confirmed_only(project)) : std::nullopt;
    std::vector<LineGuarantee> lines;
    std::uint64_t spent = 0;
    for (const LinePlan& line : plan.lines) {
        Effort effort;
        if (spent > kMostWorkOfLines) effort.most = kLeastWorkOfLine;
        lines.push_back(
            guarantee_line(project, confirmed ? *confirmed : project, line, options, scope, &effort));
        spent += effort.spent;
        if (options.progress) options.progress(lines.size(), plan.lines.size());
    }
    return lines;
}

}  // namespace takt::plan
