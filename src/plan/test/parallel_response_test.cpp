// The bounds for several requests in flight against simulations that know nothing of the analysis: no
// response may exceed its bound. Controls: with less than the truth given to the analysis, some response
// does.
#include "timing/parallel_response.hpp"

#include <gtest/gtest.h>

#include <random>

#include "parallel_simulation.hpp"

namespace takt::plan {
namespace parallel_response_test {

using Random = std::mt19937;

Microseconds between(Random& random, Microseconds least, Microseconds most) {
    return std::uniform_int_distribution<Microseconds>(least, most)(random);
}

/// Other cases in each run; the same ones with --gtest_random_seed=N.
unsigned shuffled() {
    return static_cast<unsigned>(testing::UnitTest::GetInstance()->random_seed()) * 10;
}

struct Kind {
    bool lanes = false;
    bool pause = false;
    bool alone = false;
    bool equals = false;
    bool split = false;
    bool bursts = false;
};

struct Case {
    std::vector<Task> tasks;
    Connection connection;
};

Case random_case(Random& random, const Kind& kind) {
    Case made;
    made.connection.in_flight = static_cast<std::uint32_t>(between(random, 2, 4));
    made.connection.pause = kind.pause ? between(random, 1, 6) : 0;
    made.tasks.resize(static_cast<std::size_t>(between(random, 2, 9)));
    const Microseconds shortest =
        between(random, 15, 60) * Microseconds(made.tasks.size()) / made.connection.in_flight;
    for (std::size_t i = 0; i < made.tasks.size(); ++i) {
        Task& task = made.tasks[i];
        task.frames = {between(random, 1, 30)};
        if (kind.split && between(random, 0, 1) == 0) task.frames.push_back(between(random, 1, 30));
        task.failure = 30 + between(random, 0, 60);
        task.period = between(random, 0, 9) == 0 ? 0 : shortest * between(random, 4, 30) / 4;
        task.jitter = between(random, 0, task.period / 3);
        task.burst = kind.bursts && task.period > 0 ? static_cast<std::uint32_t>(between(random, 1, 3)) : 1;
        task.priority =
            kind.equals ? static_cast<std::uint32_t>(between(random, 0, 2)) : static_cast<std::uint32_t>(i);
        task.device = static_cast<std::uint32_t>(between(random, 0, 2));
        task.attempts = static_cast<std::uint32_t>(between(random, 1, 3));
        task.backoff = between(random, 200, 2000);
    }
    made.connection.alone.resize(made.tasks.size());
    for (std::size_t i = 0; kind.alone && i < made.tasks.size(); ++i)
        made.connection.alone[i] = between(random, 0, 4) == 0;
    for (std::uint32_t device = 0; kind.lanes && device < 2; ++device) {
        Lane lane{.in_flight = static_cast<std::uint32_t>(between(random, 1, made.connection.in_flight - 1))};
        for (std::size_t i = 0; i < made.tasks.size(); ++i)
            if (made.tasks[i].device == device) lane.tasks.push_back(i);
        made.connection.lanes.push_back(lane);
    }
    return made;
}

/// Releases within the rules of each task: all at once and as dense as possible, or with slack.
std::vector<SimulatedJob> random_jobs(Random& random, const std::vector<Task>& tasks, bool dense) {
    constexpr Microseconds kLength = 1200;
    std::vector<SimulatedJob> jobs;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        const Task& task = tasks[i];
        Microseconds nominal = dense ? 0 : between(random, 0, 60);
        if (task.period == 0) {
            jobs.push_back(
                {i, nominal - between(random, 0, 3), nominal - between(random, 0, 3), task.frames});
            continue;
        }
        for (std::uint32_t extra = 1; extra < task.burst; ++extra)
            jobs.push_back({i, nominal, nominal, task.frames});
        for (bool first = true; nominal < kLength; first = false) {
            const Microseconds delay = dense ? (first ? task.jitter : 0) : between(random, 0, task.jitter);
            jobs.push_back({i, nominal, nominal + delay, task.frames});
            nominal += task.period + (dense ? 0 : between(random, 0, task.period / 4));
        }
    }
    return jobs;
}

struct Seen {
    std::size_t exceeded = 0;
    std::size_t compared = 0;
    double tightest = 0;  // greatest response / bound
};

void compare(const Responses& bounds, const std::vector<Microseconds>& responses, Seen& seen) {
    for (std::size_t i = 0; i < bounds.size(); ++i) {
        if (!bounds[i] || responses[i] == 0) continue;
        ++seen.compared;
        if (responses[i] > *bounds[i]) ++seen.exceeded;
        seen.tightest =
            std::max(seen.tightest, static_cast<double>(responses[i]) / static_cast<double>(*bounds[i]));
    }
}

using Analyse = std::function<Responses(const Case&)>;

/// @param faulting  nullptr: no attempt fails
Seen simulated(const Kind& kind, const Analyse& analyse, unsigned seed, int cases,
               const FaultRate* faults = nullptr) {
    Random random(seed + shuffled());
    Seen seen;
    for (int round = 0; round < cases; ++round) {
        const Case made = random_case(random, kind);
        const auto bounds = analyse(made);
        for (int run = 0; run < 6; ++run) {
            ParallelRules rules{.pause_after_start = between(random, 0, made.connection.pause)};
            rules.pause_after_end = made.connection.pause - rules.pause_after_start;
            if (run % 2 == 1) rules.duration = [&](Microseconds frame) { return between(random, 1, frame); };
            Faulting faulting{.wanted = [&](const SimulatedJob&) { return between(random, 0, 1) == 0; }};
            if (faults) faulting.rate = *faults;
            ParallelSimulation simulation(made.tasks, made.connection,
                                          random_jobs(random, made.tasks, run < 2), rules,
                                          faults ? &faulting : nullptr);
            compare(bounds, simulation.run(), seen);
        }
    }
    return seen;
}

Responses plain(const Case& made) {
    return parallel_response_times(made.tasks, made.connection);
}

const std::vector<Kind>& kinds() {
    static const std::vector<Kind> kKinds{
        {},
        {.equals = true},
        {.pause = true},
        {.lanes = true},
        {.alone = true},
        {.split = true, .bursts = true},
        {.lanes = true, .pause = true, .alone = true, .equals = true, .split = true, .bursts = true}};
    return kKinds;
}

TEST(ParallelResponse, NoSimulatedResponseExceedsItsBound) {
    for (const Kind& kind : kinds()) {
        const auto seen = simulated(kind, plain, 1, 90);
        EXPECT_EQ(seen.exceeded, 0U) << &kind - kinds().data();
        EXPECT_GT(seen.compared, 300U);
        EXPECT_GT(seen.tightest, 0.4);
    }
}

TEST(ParallelResponse, NorWithFailedAttempts) {
    const FaultRate faults{.burst = 2, .every = 400};
    for (const Kind& kind : kinds()) {
        const auto seen = simulated(
            kind,
            [&](const Case& made) {
                return parallel_response_times_with_faults(made.tasks, made.connection, faults);
            },
            2, 90, &faults);
        EXPECT_EQ(seen.exceeded, 0U) << &kind - kinds().data();
        EXPECT_GT(seen.compared, 100U);
    }
}

TEST(ParallelResponse, NorWithADeadDevice) {
    Random random(3 + shuffled());
    Seen seen;
    for (int round = 0; round < 120; ++round) {
        const Case made = random_case(random, kinds()[static_cast<std::size_t>(round) % kinds().size()]);
        const auto bounds = parallel_response_times_with_dead_device(made.tasks, made.connection);
        for (std::uint32_t device = 0; device < 3; ++device) {
            // Where no device is dead, the plain bounds count.
            if (std::ranges::count(made.tasks, device, &Task::device) == 0) continue;
            auto tasks = made.tasks;
            for (auto& task : tasks) {
                if (task.device != device) continue;
                task.frames.assign(task.period == 0 ? 1 : task.attempts, task.failure);
                if (task.period > 0) task.period = std::max(task.period, task.backoff);
            }
            ParallelSimulation simulation(tasks, made.connection, random_jobs(random, tasks, round % 2 == 0),
                                          {.pause_after_end = made.connection.pause});
            auto responses = simulation.run();
            for (std::size_t i = 0; i < tasks.size(); ++i)
                if (tasks[i].device == device) responses[i] = 0;
            compare(bounds, responses, seen);
        }
    }
    EXPECT_EQ(seen.exceeded, 0U);
    EXPECT_GT(seen.compared, 500U);
}

// Each of these analyses leaves out one fact. If none of its bounds were exceeded, the simulation would not
// show that the fact matters.
TEST(ParallelResponse, TheSimulationFindsWhatAnAnalysisLeavesOut) {
    const auto exceeded = [](const Kind& kind, const std::function<void(Case&)>& change) {
        return simulated(
                   kind,
                   [&](Case made) {
                       change(made);
                       return plain(made);
                   },
                   4, 200)
            .exceeded;
    };
    EXPECT_GT(exceeded({}, [](Case& made) { ++made.connection.in_flight; }), 0U);
    EXPECT_GT(exceeded({.pause = true}, [](Case& made) { made.connection.pause = 0; }), 0U);
    EXPECT_GT(exceeded({.lanes = true}, [](Case& made) { made.connection.lanes.clear(); }), 0U);
    EXPECT_GT(exceeded({.alone = true}, [](Case& made) { made.connection.alone.clear(); }), 0U);
    EXPECT_GT(exceeded({.bursts = true},
                       [](Case& made) {
                           for (auto& task : made.tasks) task.burst = 1;
                       }),
              0U);
    EXPECT_GT(exceeded({},
                       [](Case& made) {
                           for (auto& task : made.tasks) task.jitter = 0;
                       }),
              0U);
}

// One request in flight after the other needs 40 ms for four requests; four together need 10 ms.
TEST(ParallelResponse, RequestsInFlightShareTheTime) {
    std::vector<Task> tasks;
    for (std::uint32_t i = 0; i < 4; ++i)
        tasks.push_back(
            {.frames = {10'000}, .failure = 10'000, .period = 20'000, .deadline = 20'000, .priority = i});
    EXPECT_FALSE(response_times(tasks)[3]);
    const auto together = parallel_response_times(tasks, {.in_flight = 4});
    ASSERT_TRUE(together[3]);
    EXPECT_LE(*together[3], 30'000);
    EXPECT_EQ(*together[0], 10'000);  // no three others fill four slots
    for (auto& task : tasks) task.frames = {11'000};
    EXPECT_FALSE(parallel_response_times(tasks, {.in_flight = 2})[3]);  // more than two slots can do
}

TEST(ParallelResponse, ALowerPriorityDelaysByOneTransaction) {
    const std::vector<Task> tasks{{.frames = {1'000}, .period = 100'000, .priority = 0},
                                  {.frames = {5'000}, .period = 100'000, .priority = 1},
                                  {.frames = {5'000}, .period = 0, .priority = 2}};
    const auto bounds = parallel_response_times(tasks, {.in_flight = 2});
    EXPECT_EQ(bounds[0], 6'000);  // both slots have just been taken
    EXPECT_FALSE(bounds[2]);      // period 0
}

// Two long transactions beside the one that waits fill two slots with each microsecond of their time.
TEST(ParallelResponse, LongTransactionsAreNotFollowedMicrosecondByMicrosecond) {
    for (const bool lanes : {false, true}) {
        std::vector<Task> tasks;
        for (std::uint32_t i = 0; i < 3; ++i)
            tasks.push_back(
                {.frames = {500'000}, .failure = 500'000, .period = 4'000'000, .priority = i, .device = i});
        Connection connection{.in_flight = 2};
        if (lanes) connection.lanes = {{.tasks = {0, 1}, .in_flight = 2}, {.tasks = {2}, .in_flight = 1}};
        Effort effort{.most = 10'000};
        const auto bounds = parallel_response_times(tasks, connection, &effort);
        EXPECT_FALSE(effort.exhausted) << lanes;
        ASSERT_TRUE(bounds[2]) << lanes;
        EXPECT_LE(*bounds[2], 1'500'000) << lanes;
    }
}

TEST(ParallelResponse, AnExhaustedEffortLeavesNoBound) {
    std::vector<Task> tasks(50, {.frames = {10}, .period = 1'000});
    Effort effort{.most = 10};
    const auto bounds = parallel_response_times(tasks, {.in_flight = 2}, &effort);
    EXPECT_TRUE(effort.exhausted);
    EXPECT_FALSE(bounds[0]);
}

}  // namespace parallel_response_test
}  // namespace takt::plan
