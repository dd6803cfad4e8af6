// A connection with several requests in flight in virtual time. Small and slow on purpose: it shares nothing
// with the analysis it checks.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "queue_simulation.hpp"
#include "timing/parallel_response.hpp"

namespace takt::plan {

struct ParallelRules {
    Microseconds pause_after_start = 0;
    Microseconds pause_after_end = 0;
    /// The time that a transaction takes, at most its frame.
    std::function<Microseconds(Microseconds frame)> duration = [](Microseconds frame) { return frame; };
};

/// The longest response of each task over all its jobs, in the order of their releases.
class ParallelSimulation {
public:
    ParallelSimulation(const std::vector<Task>& tasks, const Connection& connection,
                       std::vector<SimulatedJob> jobs, ParallelRules rules,
                       const Faulting* faulting = nullptr)
        : tasks_(tasks),
          connection_(connection),
          rules_(std::move(rules)),
          faulting_(faulting),
          longest_(tasks.size(), 0) {
        for (auto& job : jobs) jobs_.push_back({.job = std::move(job)});
        std::ranges::stable_sort(jobs_, {}, [](const Running& each) { return each.job.release; });
    }

    std::vector<Microseconds> run() {
        for (now_ = jobs_.empty() ? 0 : jobs_.front().job.release; now_ < kNever;) {
            end_due();
            start_due();
            Microseconds next = kNever;
            for (const auto& each : jobs_) {
                if (each.in_flight) next = std::min(next, each.ends);
                if (!each.done && each.job.release > now_) next = std::min(next, each.job.release);
            }
            if (free_at_ > now_) next = std::min(next, free_at_);
            now_ = next;
        }
        return longest_;
    }

private:
    static constexpr Microseconds kNever = std::numeric_limits<Microseconds>::max();
    struct Running {
        SimulatedJob job;
        std::size_t sent = 0;
        bool in_flight = false;
        bool failing = false;
        bool done = false;
        Microseconds ends = 0;
    };

    void end_due() {
        for (auto& each : jobs_) {
            if (!each.in_flight || each.ends > now_) continue;
            each.in_flight = false;
            free_at_ = std::max(free_at_, now_ + rules_.pause_after_end);
            if (!each.failing) ++each.sent;
            each.done = each.sent == each.job.frames.size();
            if (each.done)
                longest_[each.job.task] = std::max(longest_[each.job.task], now_ - each.job.nominal);
        }
    }

    [[nodiscard]] std::size_t in_flight(const std::function<bool(const Running&)>& counts) const {
        return static_cast<std::size_t>(std::ranges::count_if(
            jobs_, [&](const Running& each) { return each.in_flight && counts(each); }));
    }

    [[nodiscard]] bool eligible(const Running& job) const {
        if (job.done || job.in_flight || job.job.release > now_) return false;
        for (const auto& each : jobs_) {
            if (&each == &job) break;
            if (each.job.task == job.job.task && !each.done) return false;  // one after the other
        }
        return std::ranges::all_of(connection_.lanes, [&](const Lane& lane) {
            const auto is_in = [&](std::size_t task) { return std::ranges::count(lane.tasks, task) > 0; };
            return !is_in(job.job.task) ||
                   in_flight([&](const Running& each) { return is_in(each.job.task); }) < lane.in_flight;
        });
    }

    [[nodiscard]] bool alone(const Running& job) const {
        return !connection_.alone.empty() && connection_.alone[job.job.task];
    }

    void start_due() {
        while (now_ >= free_at_) {
            const auto all = in_flight([](const Running&) { return true; });
            if (all >= connection_.in_flight ||
                in_flight([&](const Running& each) { return alone(each); }) > 0)
                return;
            Running* best = nullptr;
            for (auto& each : jobs_)
                if (eligible(each) && (!best || rank(each) < rank(*best))) best = &each;
            if (!best || (alone(*best) && all > 0)) return;
            start(*best);
        }
    }

    [[nodiscard]] std::pair<bool, std::uint32_t> rank(const Running& job) const {
        const Task& task = tasks_[job.job.task];
        return {task.period == 0, task.priority};
    }

    void start(Running& job) {
        job.in_flight = true;
        job.failing =
            faulting_ && faulting_->wanted(job.job) && rate_allows(faulting_->rate, failures_, now_);
        if (job.failing) failures_.push_back(now_);
        job.ends =
            now_ + (job.failing ? tasks_[job.job.task].failure : rules_.duration(job.job.frames[job.sent]));
        free_at_ = std::max(free_at_, now_ + rules_.pause_after_start);
    }

    const std::vector<Task>& tasks_;
    const Connection& connection_;
    ParallelRules rules_;
    const Faulting* faulting_;
    std::vector<Microseconds> longest_;
    std::vector<Running> jobs_;
    std::vector<Microseconds> failures_;
    Microseconds now_ = 0;
    Microseconds free_at_ = std::numeric_limits<Microseconds>::min();
};

}  // namespace takt::plan
