// A simulation of the master's scheduler in exact bus times, without failures: non-preemptive, at each
// instant the most urgent due request. Classes: overdue requests (order: deadline), due requests, requests
// with period 0. Bus times are rounded up to nanoseconds per part.
#include "takt/plan/timeline.hpp"

#include <algorithm>
#include <optional>
#include <tuple>

#include "cost/exact_time.hpp"
#include "takt/base/assert.hpp"
#include "timing/calendar.hpp"
#include "timing/streams.hpp"

namespace takt::plan {
namespace {

constexpr std::int64_t kMostShortestPeriods = 100;

/// The state of one polled request during the simulation.
struct Job {
    std::size_t request = 0;
    bool background = false;  ///< period 0
    Duration due{};           ///< of background jobs: when it was last sent
    Duration period{};
    Duration deadline{};
    std::array<Duration, kParts> ends{};
};

class Master {
public:
    Master(const model::Line& line, const LinePlan& plan);

    [[nodiscard]] std::optional<std::size_t> most_urgent(Duration now);
    [[nodiscard]] Duration next_due() const;
    Bar send(std::size_t job, Duration now);

private:
    /// Order: class, then time, then position; the least is sent first.
    using Rank = std::tuple<int, Duration, std::size_t>;
    [[nodiscard]] Rank rank(std::size_t job, Duration now) const;

    std::vector<Job> jobs_;
    bool rounds_;
    std::size_t cursor_ = 0;
};

Master::Master(const model::Line& line, const LinePlan& plan)
    : rounds_(line.order == model::PollOrder::address) {
    const BusTimeModel bus_times(line);
    for (std::size_t i = 0; i < plan.requests.size(); ++i) {
        const Request& request = plan.requests[i];
        if (!request.read || !request.period) continue;
        const model::Device& device = line.devices[request.device];
        Job job{.request = i, .background = !is_periodic(request), .due = request.phase};
        job.period = *request.period;
        job.deadline = request.deadline.value_or(job.period);
        std::ranges::transform(bus_times.parts(device, request.request_bytes, request.response_bytes,
                                               estimated_turnaround(device)),
                               job.ends.begin(), [&](ExactTime time) { return bus_times.rounded_up(time); });
        jobs_.push_back(job);
    }
}

Master::Rank Master::rank(std::size_t job, Duration now) const {
    const Job& one = jobs_[job];
    if (one.background) return {2, one.due, job};
    if (rounds_) return {1, Duration::zero(), (job + jobs_.size() - cursor_) % jobs_.size()};
    if (now - one.due > one.deadline) return {0, one.due + one.deadline, job};
    return {1, one.deadline, job};
}

std::optional<std::size_t> Master::most_urgent(Duration now) {
    std::optional<std::size_t> best;
    const bool polling =
        std::ranges::any_of(jobs_, [now](const Job& job) { return !job.background && job.due <= now; });
    if (!polling) cursor_ = 0;
    for (std::size_t i = 0; i < jobs_.size(); ++i)
        if (jobs_[i].due <= now && (!best || rank(i, now) < rank(*best, now))) best = i;
    return best;
}

Duration Master::next_due() const {
    return jobs_.empty() ? Duration::max() : std::ranges::min(jobs_, {}, &Job::due).due;
}

Bar Master::send(std::size_t index, Duration now) {
    Job& job = jobs_[index];
    Bar bar{.request = job.request, .due = job.background ? now : job.due, .start = now, .ends = job.ends};
    bar.late = !job.background && bar.end() - bar.due > job.deadline;
    cursor_ = index + 1;
    job.due = job.background ? now : job.due + job.period * ((now - job.due) / job.period + 1);
    return bar;
}

}  // namespace

RoundWindow round_window(const LinePlan& plan) {
    Duration shortest = Duration::max();
    Duration repeats{};
    for (const Request& request : plan.requests) {
        if (!is_periodic(request)) continue;
        shortest = std::min(shortest, *request.period);
        const std::int64_t all = std::max<std::int64_t>(repeats.count(), 1);
        repeats = Duration(common_multiple(all, request.period->count(), Duration::max().count())
                               .value_or(Duration::max().count()));
    }
    if (repeats == Duration::zero()) return {plan.cycle, repeats, true};
    const Duration most =
        shortest > Duration::max() / kMostShortestPeriods ? Duration::max() : shortest * kMostShortestPeriods;
    const Duration length = std::max(std::min(repeats, most), plan.cycle);
    return {length, repeats, length >= repeats};
}

Timeline timeline(const model::Line& line, const LinePlan& plan, Duration window, std::size_t most_bars) {
    Timeline made{.window = window};
    Master master(line, plan);
    for (Duration now = master.next_due(); now < window;) {
        const auto job = master.most_urgent(now);
        if (!job) {
            now = master.next_due();
            continue;
        }
        if (made.bars.size() == most_bars) {
            made.cut = true;
            break;
        }
        made.bars.push_back(master.send(*job, now));
        now = made.bars.back().end();
    }
    return made;
}

}  // namespace takt::plan
