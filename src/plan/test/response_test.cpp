#include "takt/plan/response.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "queue_simulation.hpp"
#include "response_reference.hpp"

namespace takt::plan {
namespace response_test {

using Random = std::mt19937;

Microseconds between(Random& random, Microseconds least, Microseconds most) {
    return std::uniform_int_distribution<Microseconds>(least, most)(random);
}

std::vector<Microseconds> random_frames(Random& random, std::size_t least) {
    std::vector<Microseconds> frames(static_cast<std::size_t>(between(random, Microseconds(least), 3)));
    for (auto& frame : frames) frame = between(random, 1, 20);
    return frames;
}

struct Kind {
    bool shapes = false;
    bool equals = false;
    bool bursts = false;
    bool jitter = false;
    bool split = false;
};

// Some lines are idle, some overloaded, most between.
std::vector<Task> random_line(Random& random, const Kind& kind) {
    std::vector<Task> tasks(static_cast<std::size_t>(between(random, 1, 7)));
    const Microseconds shortest = between(random, 10, 40) * Microseconds(tasks.size());
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        Task& task = tasks[i];
        task.frames = kind.split ? random_frames(random, 1) : std::vector{between(random, 1, 30)};
        if (kind.shapes && between(random, 0, 2) == 0) {
            task.shapes.resize(static_cast<std::size_t>(between(random, 2, 6)));
            for (auto& shape : task.shapes) shape = random_frames(random, 0);
            task.shapes.front() = random_frames(random, 1);
        }
        task.failure = reference::longest_frame(task) + between(random, 0, 20);
        task.period = between(random, 0, 12) == 0 ? 0 : shortest * between(random, 4, 30) / 4;
        task.deadline = task.period * between(random, 2, 8) / 4;
        task.jitter = kind.jitter ? between(random, 0, task.period / 2) : 0;
        task.burst = kind.bursts ? static_cast<std::uint32_t>(between(random, 1, 3)) : 1;
        task.priority =
            kind.equals ? static_cast<std::uint32_t>(between(random, 0, 2)) : static_cast<std::uint32_t>(i);
        task.device = static_cast<std::uint32_t>(between(random, 0, 2));
        task.attempts = static_cast<std::uint32_t>(between(random, 1, 3));
        task.backoff = between(random, 0, 2000);
    }
    return tasks;
}

std::vector<Kind> kinds() {
    return {{},
            {.jitter = true},
            {.bursts = true, .jitter = true},
            {.equals = true, .jitter = true},
            {.jitter = true, .split = true},
            {.shapes = true},
            {.shapes = true, .equals = true, .bursts = true, .jitter = true, .split = true}};
}

FaultRate random_faults(Random& random) {
    return {.burst = static_cast<std::uint32_t>(between(random, 0, 3)), .every = between(random, 100, 2000)};
}

TEST(Response, EqualsTheEquations) {
    Random random(1);
    std::size_t bounded = 0;
    std::size_t all = 0;
    for (const Kind& kind : kinds()) {
        for (int round = 0; round < 60; ++round) {
            const auto tasks = random_line(random, kind);
            const auto faults = random_faults(random);
            const auto found = response_times(tasks);
            EXPECT_EQ(found, reference::responses(tasks));
            EXPECT_EQ(response_times_with_faults(tasks, faults), reference::responses(tasks, faults));
            for (const auto& response : found) bounded += response.has_value() ? 1U : 0U;
            all += found.size();
        }
    }
    EXPECT_GT(bounded * 10, all * 7);  // else nothing was compared
    EXPECT_LT(bounded, all);
}

TEST(Response, DeadDeviceIsTheWorstOfAllOthers) {
    Random random(2);
    for (int round = 0; round < 100; ++round) {
        const auto tasks = random_line(random, kinds().back());
        std::vector<std::optional<Microseconds>> worst(tasks.size(), Microseconds{0});
        std::set<std::uint32_t> devices;
        for (const auto& task : tasks) devices.insert(task.device);
        for (const auto device : devices) {
            auto changed = tasks;
            for (Task& task : changed) {
                if (task.device != device) continue;
                task.frames.assign(task.attempts, task.failure);
                task.shapes.clear();
                if (task.period > 0) task.period = std::max(task.period, task.backoff);
            }
            const auto found = reference::responses(changed);
            for (std::size_t i = 0; i < tasks.size(); ++i) {
                if (tasks[i].device == device) continue;
                worst[i] = worst[i] && found[i] ? std::max(worst[i], found[i]) : std::nullopt;
            }
        }
        EXPECT_EQ(response_times_with_dead_device(tasks),
                  devices.size() > 1 ? Responses(worst) : response_times(tasks));
    }
}

/// Every job up to a horizon. Adversarial: all are released together as early and as densely as they may,
/// just after the longest frame that may block `victim` began.
class Releases {
public:
    Releases(const std::vector<Task>& tasks, Random& random) : tasks_(tasks), random_(random) {}

    std::vector<SimulatedJob> adversarial(std::size_t victim, Microseconds horizon, bool deadlines);
    std::vector<SimulatedJob> at_random(Microseconds horizon);

private:
    void add(std::size_t task, Microseconds nominal, Microseconds release);
    void add_blocker(std::size_t victim, bool deadlines);

    const std::vector<Task>& tasks_;
    Random& random_;
    std::vector<SimulatedJob> jobs_;
    std::vector<std::size_t> shape_ = std::vector<std::size_t>(tasks_.size());
};

void Releases::add(std::size_t task, Microseconds nominal, Microseconds release) {
    const auto shapes = reference::shapes(tasks_[task]);
    jobs_.push_back({task, nominal, release, shapes[shape_[task]++ % shapes.size()]});
}

void Releases::add_blocker(std::size_t victim, bool deadlines) {
    std::optional<SimulatedJob> blocker;
    for (std::size_t k = 0; k < tasks_.size(); ++k) {
        const Task& task = tasks_[k];
        const bool blocks =
            task.period == 0 ||
            (deadlines ? task.deadline - task.jitter > tasks_[victim].deadline - tasks_[victim].jitter
                       : task.priority > tasks_[victim].priority);
        const Microseconds frame = reference::longest_frame(task);
        if (k != victim && blocks && (!blocker || frame > blocker->frames.front()))
            blocker = SimulatedJob{k, -1, -1, {frame}};
    }
    if (blocker) jobs_.push_back(*blocker);
}

std::vector<SimulatedJob> Releases::adversarial(std::size_t victim, Microseconds horizon, bool deadlines) {
    add_blocker(victim, deadlines);
    for (std::size_t n = 0; n < tasks_.size(); ++n) {
        const std::size_t i = (victim + 1 + n) % tasks_.size();  // the victim last among equals
        const Task& task = tasks_[i];
        if (task.period == 0 || (!jobs_.empty() && jobs_.front().task == i && jobs_.front().release < 0))
            continue;
        if (!task.shapes.empty()) shape_[i] = static_cast<std::size_t>(between(random_, 0, 5));
        for (std::uint32_t b = 1; b < task.burst; ++b) add(i, -task.jitter, 0);
        for (Microseconds t = -task.jitter; t < horizon; t += task.period)
            add(i, t, std::max<Microseconds>(t, 0));
    }
    return std::move(jobs_);
}

std::vector<SimulatedJob> Releases::at_random(Microseconds horizon) {
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
        const Task& task = tasks_[i];
        const Microseconds period = std::max<Microseconds>(task.period, 50);
        const std::uint32_t burst = task.period == 0 ? 1 : task.burst;
        const Microseconds first = between(random_, 0, period);
        for (std::uint32_t b = 1; b < burst; ++b) add(i, first, first + between(random_, 0, task.jitter));
        for (Microseconds t = first; t < horizon;
             t += period + between(random_, 0, 1) * between(random_, 0, period))
            add(i, t, t + between(random_, 0, task.jitter));
    }
    return std::move(jobs_);
}

struct Tally {
    std::size_t reached = 0;
    std::size_t tried = 0;
};

void expect_not_above(const std::vector<Microseconds>& seen, const Responses& bounds) {
    for (std::size_t i = 0; i < seen.size(); ++i)
        ASSERT_LE(seen[i], bounds[i].value_or(seen[i])) << "task " << i;
}

// The failures: the costliest attempts that can delay the victim, or first the frame that blocks it.
Faulting worst_faults(const std::vector<Task>& tasks, std::size_t victim, const FaultRate& rate,
                      bool blocker) {
    Microseconds most = 0;
    for (const Task& task : tasks)
        if (task.period > 0 && task.priority <= tasks[victim].priority) most = std::max(most, task.failure);
    return {rate, [&tasks, victim, most, blocker](const SimulatedJob& job) {
                const Task& task = tasks[job.task];
                if (job.release < 0) return blocker;
                return task.period > 0 && task.priority <= tasks[victim].priority && task.failure == most;
            }};
}

// A blocking frame begins a tick before, the bound lets it begin at the same moment: one tick of difference.
void attack(const std::vector<Task>& tasks, Random& random, const Responses& bounds,
            const std::optional<FaultRate>& faults, Tally& tally) {
    constexpr Microseconds kHorizon = 2000;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        if (!bounds[i] || *bounds[i] > kHorizon) continue;
        Microseconds longest = 0;
        for (int attempt = 0; attempt < 4; ++attempt) {
            const auto jobs = Releases(tasks, random).adversarial(i, kHorizon, false);
            const auto faulting = worst_faults(tasks, i, faults.value_or(FaultRate{}), attempt % 2 == 0);
            const auto seen = simulate(tasks, jobs, Policy::fixed_priority, faults ? &faulting : nullptr);
            expect_not_above(seen, bounds);
            longest = std::max(longest, seen[i]);
        }
        ++tally.tried;
        tally.reached += longest >= *bounds[i] - 1 ? 1U : 0U;
    }
}

TEST(Response, NoScheduleIsAboveTheBoundAndMostAttacksReachIt) {
    Random random(3);
    Tally single;
    Tally mixed;
    for (const Kind& kind : kinds()) {
        for (int round = 0; round < 30; ++round) {
            const auto tasks = random_line(random, kind);
            const auto bounds = response_times(tasks);
            attack(tasks, random, bounds, std::nullopt, kind.shapes ? mixed : single);
            expect_not_above(simulate(tasks, Releases(tasks, random).at_random(2000), Policy::fixed_priority),
                             bounds);
        }
    }
    EXPECT_GT(single.reached, single.tried * 9 / 10) << single.reached << " of " << single.tried;
    EXPECT_GT(mixed.reached, mixed.tried * 6 / 10) << mixed.reached << " of " << mixed.tried;
}

TEST(Response, NoFailuresLiftAScheduleAboveTheBound) {
    Random random(4);
    Tally tally;
    for (const Kind& kind : kinds()) {
        for (int round = 0; round < 30; ++round) {
            auto tasks = random_line(random, kind);
            const auto rate = random_faults(random);
            const auto bounds = response_times_with_faults(tasks, rate);
            attack(tasks, random, bounds, rate, tally);
            const Faulting any{rate, [&](const SimulatedJob&) { return between(random, 0, 3) == 0; }};
            const auto jobs = Releases(tasks, random).at_random(2000);
            expect_not_above(simulate(tasks, jobs, Policy::fixed_priority, &any), bounds);
        }
    }
    EXPECT_GT(tally.reached, tally.tried / 2) << tally.reached << " of " << tally.tried;
}

bool a_deadline_is_missed(const std::vector<Task>& tasks, const std::vector<Microseconds>& seen) {
    for (std::size_t i = 0; i < tasks.size(); ++i)
        if (tasks[i].period > 0 && seen[i] > tasks[i].deadline) return true;
    return false;
}

TEST(EarliestDeadline, FeasibleSetsNeverMissAndMostOthersDo) {
    Random random(5);
    std::size_t infeasible = 0;
    std::size_t missed = 0;
    std::size_t feasible = 0;
    for (const Kind& kind : kinds()) {
        for (int round = 0; round < 60; ++round) {
            const auto tasks = random_line(random, kind);
            const auto rate = random_faults(random);
            const Faulting any{rate, [&](const SimulatedJob&) { return between(random, 0, 2) == 0; }};
            const bool proved = feasible_edf(tasks);
            const bool proved_with_faults = feasible_edf(tasks, rate);
            EXPECT_TRUE(proved || !proved_with_faults);
            bool miss = false;
            for (std::size_t i = 0; i < tasks.size(); ++i) {
                const auto jobs = Releases(tasks, random).adversarial(i, 2000, true);
                miss = miss || a_deadline_is_missed(tasks, simulate(tasks, jobs, Policy::earliest_deadline));
                const auto seen = simulate(tasks, jobs, Policy::earliest_deadline, &any);
                EXPECT_FALSE(proved_with_faults && a_deadline_is_missed(tasks, seen));
            }
            const auto jobs = Releases(tasks, random).at_random(2000);
            miss = miss || a_deadline_is_missed(tasks, simulate(tasks, jobs, Policy::earliest_deadline));
            EXPECT_FALSE(proved && miss);
            feasible += proved ? 1U : 0U;
            infeasible += proved ? 0 : 1;
            missed += !proved && miss ? 1U : 0U;
        }
    }
    EXPECT_GT(feasible, 50U);
    EXPECT_GT(missed, infeasible * 8 / 10) << missed << " of " << infeasible;
}

TEST(Response, OverloadAndPeriodZeroHaveNoBoundButWhatIsMoreUrgentHas) {
    std::vector<Task> tasks(3);
    for (std::uint32_t i = 0; i < 3; ++i) {
        tasks[i].frames = {60};
        tasks[i].period = 100;
        tasks[i].priority = i;
    }
    EXPECT_EQ(response_times(tasks), (Responses{120, std::nullopt, std::nullopt}));
    tasks[1].period = 0;
    tasks.pop_back();
    EXPECT_EQ(response_times(tasks), (Responses{120, std::nullopt}));
    EXPECT_FALSE(feasible_edf(std::vector<Task>{{.frames = {60}, .period = 50, .deadline = 50}}));
}

TEST(Response, HeldBackForLateAnswers) {
    std::vector<Task> tasks(2);
    tasks[0] = {.frames = {10}, .failure = 20, .period = 1000, .priority = 0, .late = 300};
    tasks[1] = {.frames = {15}, .failure = 25, .period = 1000, .priority = 1};
    const FaultRate once{.burst = 1, .every = 1'000'000};
    EXPECT_EQ(response_times(tasks), (Responses{25, 25}));  // late answers are those of failures
    EXPECT_EQ(response_times_with_faults(tasks, once), (Responses{15 + 20 + 300 + 10, 25 + 25}));
    tasks[0].late = 990;  // held back so long that its next job follows at once
    EXPECT_EQ(response_times_with_faults(tasks, once)[1], 25 + 2 * 10 + 15);
}

// With any limit of work, a bound is never below the exact one, and equals it where the limit was not
// reached.
TEST(Response, BoundsOfALimitedAnalysisAreNotBelowTheExactOnes) {
    Random random(7);
    int rough = 0;
    int larger = 0;
    for (int i = 0; i < 2'000; ++i) {
        const auto tasks = random_line(random, {.shapes = i % 3 == 0, .bursts = true, .jitter = true});
        const auto exact = response_times(tasks);
        Effort effort{.most = static_cast<std::uint64_t>(between(random, 0, 300))};
        const auto limited = response_times(tasks, &effort);
        rough += effort.exhausted ? 1 : 0;
        if (!effort.exhausted) {
            EXPECT_EQ(limited, exact) << i;
        }
        for (std::size_t k = 0; k < tasks.size(); ++k) {
            if (!limited[k]) continue;
            ASSERT_TRUE(exact[k]) << i;
            EXPECT_GE(*limited[k], *exact[k]) << i;
            larger += *limited[k] > *exact[k] ? 1 : 0;
        }
    }
    EXPECT_GT(rough, 100);
    EXPECT_GT(larger, 100);
}

TEST(Response, NothingOverflowsAndManyTasksAreBounded) {
    constexpr Microseconds kDay = Microseconds{24} * 3600 * 1'000'000;
    std::vector<Task> tasks(20'000);
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        const auto number = static_cast<std::uint32_t>(i);
        tasks[i] = {.frames = {2'000'000 + Microseconds(i % 7)},
                    .failure = 5'000'000,
                    .period = kDay - Microseconds(i % 50),
                    .deadline = kDay,
                    .jitter = 1000,
                    .burst = 1,
                    .priority = number,
                    .device = number % 100,
                    .attempts = 3,
                    .backoff = kDay};
    }
    const auto responses = response_times(tasks);
    ASSERT_TRUE(responses.back());
    EXPECT_EQ(*responses.front(), 2 * 2'000'006 - 6 + 1000);
    EXPECT_GE(*responses.back(), 20'000 * Microseconds{2'000'000});
    Effort effort{.most = 100'000};
    (void)response_times(tasks, &effort);
    EXPECT_GT(effort.spent, effort.most);
    EXPECT_TRUE(effort.exhausted);
    EXPECT_LT(effort.spent, 10 * effort.most) << "ends soon after the limit";
    const auto spent = effort.spent;
    const auto by_rates = response_times(tasks, &effort);
    EXPECT_LT(effort.spent, spent + 10 * effort.most);
    ASSERT_TRUE(by_rates.back());
    EXPECT_GE(*by_rates.back(), *responses.back());
    tasks.back().frames = {kDay};  // still below one, in all
    EXPECT_TRUE(response_times(tasks).front());
    for (Task& task : tasks) task.frames = {kDay * 365};
    EXPECT_EQ(response_times(tasks).back(), std::nullopt);
    EXPECT_FALSE(feasible_edf(tasks));
}

}  // namespace response_test
}  // namespace takt::plan
