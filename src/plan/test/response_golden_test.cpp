#include <gtest/gtest.h>

#include "golden_responses.hpp"
#include "takt/plan/response.hpp"

namespace takt::plan {
namespace response_golden_test {

std::vector<Task> tasks_of(const golden::Set& set) {
    std::vector<Task> tasks;
    for (const auto& row : set.rows) {
        const auto number = static_cast<std::uint32_t>(tasks.size());
        tasks.push_back({.frames = row.frames,
                         .failure = row.failure,
                         .period = row.period,
                         .deadline = row.deadline,
                         .jitter = 1000,
                         .priority = number,
                         .device = number,
                         .attempts = 2,
                         .backoff = 10'000'000});
    }
    return tasks;
}

TEST(Response, GoldenSets) {
    for (const auto& set : golden::sets()) {
        const auto tasks = tasks_of(set);
        const auto plain = response_times(tasks);
        const auto faults = response_times_with_faults(tasks, FaultRate{});
        const auto dead = response_times_with_dead_device(tasks);
        for (std::size_t i = 0; i < tasks.size(); ++i) {
            SCOPED_TRACE(std::string(set.name) + ": " + set.rows[i].name);
            const auto& row = set.rows[i];
            EXPECT_EQ(plain[i], row.response);
            EXPECT_EQ(faults[i], row.response_with_fault);
            EXPECT_EQ(dead[i], row.response_with_dead);
            EXPECT_EQ(plain[i] <= row.deadline, row.ok);
            EXPECT_EQ(faults[i] <= row.deadline, row.ok_with_fault);
            EXPECT_EQ(dead[i] <= row.deadline, row.ok_with_dead);
        }
        EXPECT_NEAR(utilization(tasks), set.utilization, 1e-6) << set.name;
        EXPECT_EQ(feasible_edf(tasks), set.edf) << set.name;
        EXPECT_EQ(feasible_edf(tasks, FaultRate{}), set.edf_with_fault) << set.name;
    }
}

// The first job of the last task is not its slowest: the flaw of the early analysis of CAN.
TEST(Response, EveryJobOfTheBusyPeriodCounts) {
    std::vector<Task> tasks(3);
    const Microseconds periods[] = {2500, 3500, 3500};
    const Microseconds deadlines[] = {2500, 3250, 3250};
    for (std::uint32_t i = 0; i < 3; ++i) {
        tasks[i].frames = {1000};
        tasks[i].period = periods[i];
        tasks[i].deadline = deadlines[i];
        tasks[i].priority = i;
    }
    EXPECT_EQ(response_times(tasks), (Responses{2000, 3000, 3500}));
}

}  // namespace response_golden_test
}  // namespace takt::plan
