#include "takt/os/realtime.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <thread>

namespace takt::os {
namespace realtime_test {

const RealtimeResult* find(const std::vector<RealtimeResult>& results, RealtimeStep step) {
    const auto found = std::ranges::find(results, step, &RealtimeResult::step);
    return found == results.end() ? nullptr : &*found;
}

template <class Function>
void on_own_thread(Function function) {
    std::thread(function).join();
}

TEST(Realtime, WithoutOptionsNothingIsDone) {
    EXPECT_TRUE(become_realtime({}).empty());
}

TEST(Realtime, AProcessorAloneOnlyPins) {
    on_own_thread([] {
        cpu_set_t allowed;
        ASSERT_EQ(::sched_getaffinity(0, sizeof allowed, &allowed), 0);
        int last = CPU_SETSIZE - 1;
        while (!CPU_ISSET(static_cast<unsigned>(last), &allowed)) --last;
        const auto results = become_realtime({.cpu = last});
        ASSERT_EQ(results.size(), 1U);
        EXPECT_EQ(results[0].step, RealtimeStep::processor);
        EXPECT_EQ(results[0].error, 0);
        EXPECT_EQ(::sched_getcpu(), last);
        EXPECT_EQ(::sched_getscheduler(0), SCHED_OTHER);
    });
}

TEST(Realtime, AProcessorThatDoesNotExistIsAnError) {
    on_own_thread([] {
        EXPECT_EQ(become_realtime({.cpu = CPU_SETSIZE - 1})[0].error, EINVAL);
        EXPECT_EQ(become_realtime({.cpu = CPU_SETSIZE})[0].error, EINVAL);
        EXPECT_EQ(become_realtime({.cpu = -1})[0].error, EINVAL);
    });
}

// With the rights to do so, the class is set; without them, the reason is in the result.
TEST(Realtime, APriorityIsInForceOrRefused) {
    on_own_thread([] {
        constexpr int kPriority = 7;
        const auto results = become_realtime({.priority = kPriority});
        EXPECT_EQ(results.size(), 5U);
        EXPECT_EQ(find(results, RealtimeStep::processor), nullptr);
        EXPECT_EQ(find(results, RealtimeStep::timer_slack)->error, 0);
        EXPECT_LE(::prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0), 1);  // 0 with SCHED_FIFO
        const auto scheduling = find(results, RealtimeStep::scheduling)->error;
        if (scheduling != 0) {
            EXPECT_EQ(scheduling, EPERM);
            return;
        }
        sched_param parameter{};
        ASSERT_EQ(::sched_getparam(0, &parameter), 0);
        EXPECT_EQ(parameter.sched_priority, kPriority);
        EXPECT_EQ(::sched_getscheduler(0) & ~SCHED_RESET_ON_FORK, SCHED_FIFO);
        on_own_thread([] { EXPECT_EQ(::sched_getscheduler(0), SCHED_OTHER); });
    });
}

}  // namespace realtime_test
}  // namespace takt::os
