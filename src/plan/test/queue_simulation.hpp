// A line in virtual time, one tick after the other choice: jobs of frames in a queue without preemption.
// Small and slow on purpose: it shares nothing with the analysis it checks.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "takt/plan/response.hpp"

namespace takt::plan {

struct SimulatedJob {
    std::size_t task = 0;
    Microseconds nominal = 0;  ///< response and deadline count from here
    Microseconds release = 0;  ///< it is in the queue from here
    std::vector<Microseconds> frames;
};

enum class Policy { fixed_priority, earliest_deadline };

/// Failed attempts that happen: one whenever `wanted` and the rate allows it.
struct Faulting {
    FaultRate rate;
    std::function<bool(const SimulatedJob&)> wanted;
};

/// Whether one more failure at `t` keeps every closed window t within burst + floor(t / every).
inline bool rate_allows(const FaultRate& rate, const std::vector<Microseconds>& failures, Microseconds t) {
    if (rate.burst == 0) return false;
    for (std::size_t back = 1; back <= failures.size(); ++back) {
        const Microseconds window = t - failures[failures.size() - back];
        if (static_cast<Microseconds>(back) + 1 > rate.burst + window / rate.every) return false;
    }
    return true;
}

/// The longest response of each task over all its jobs. @param jobs  ties are served in their order
inline std::vector<Microseconds> simulate(const std::vector<Task>& tasks, std::vector<SimulatedJob> jobs,
                                          Policy policy, const Faulting* faulting = nullptr) {
    std::vector<Microseconds> longest(tasks.size(), 0);
    std::vector<std::size_t> sent(jobs.size(), 0);
    std::vector<Microseconds> failures;
    const auto rank = [&](const SimulatedJob& job) -> std::pair<Microseconds, Microseconds> {
        const Task& task = tasks[job.task];
        const bool blocks = task.period == 0;
        constexpr auto kLast = std::numeric_limits<Microseconds>::max();
        if (policy == Policy::earliest_deadline) return {blocks ? kLast : job.nominal + task.deadline, 0};
        return {blocks ? kLast : Microseconds{task.priority}, job.release};
    };
    Microseconds now = std::numeric_limits<Microseconds>::min();
    for (std::size_t left = jobs.size(); left > 0;) {
        std::size_t best = jobs.size();
        Microseconds next = std::numeric_limits<Microseconds>::max();
        for (std::size_t i = 0; i < jobs.size(); ++i) {
            if (sent[i] == jobs[i].frames.size() && !jobs[i].frames.empty()) continue;
            if (jobs[i].frames.empty()) continue;
            if (jobs[i].release > now)
                next = std::min(next, jobs[i].release);
            else if (best == jobs.size() || rank(jobs[i]) < rank(jobs[best]))
                best = i;
        }
        if (best == jobs.size()) {
            if (next == std::numeric_limits<Microseconds>::max()) break;
            now = next;
            continue;
        }
        SimulatedJob& job = jobs[best];
        if (faulting && faulting->wanted(job) && rate_allows(faulting->rate, failures, now)) {
            failures.push_back(now);
            now += tasks[job.task].failure;
            continue;
        }
        now += job.frames[sent[best]++];
        if (sent[best] == job.frames.size()) {
            longest[job.task] = std::max(longest[job.task], now - job.nominal);
            --left;
        }
    }
    return longest;
}

}  // namespace takt::plan
