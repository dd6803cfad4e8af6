#include "takt/os/worker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <latch>
#include <memory>
#include <thread>
#include <vector>

namespace takt::os {
namespace worker_test {

using namespace std::chrono_literals;
using AtEnd = Worker::AtEnd;

/// Occupies a thread of the worker until it is released.
class Blocker {
public:
    [[nodiscard]] bool start(Worker& worker) {
        std::promise<void> started;
        auto is_started = started.get_future();
        const bool posted = worker.post([started = std::move(started), end = end_.get_future()]() mutable {
            started.set_value();
            end.wait();
        });
        if (posted) is_started.wait();
        return posted;
    }
    void release() { end_.set_value(); }

private:
    std::promise<void> end_;
};

TEST(Worker, RunsJobsInTheOrderTheyWerePosted) {
    std::vector<int> order;
    Worker worker({.queue = 100});
    Blocker blocker;
    ASSERT_TRUE(blocker.start(worker));
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(worker.post([&order, i] { order.push_back(i); }));
    blocker.release();
    worker.finish();
    ASSERT_EQ(order.size(), 100u);
    EXPECT_TRUE(std::ranges::is_sorted(order));
}

TEST(Worker, RejectsAJobWhenTheQueueIsFull) {
    std::atomic<int> count = 0;
    Worker worker({.queue = 2});
    Blocker blocker;
    ASSERT_TRUE(blocker.start(worker));
    EXPECT_TRUE(worker.post([&] { ++count; }));
    EXPECT_TRUE(worker.post([&] { ++count; }));
    EXPECT_FALSE(worker.post([&] { ++count; }));
    blocker.release();
    worker.finish();
    EXPECT_EQ(count, 2);
}

TEST(Worker, DiscardsWaitingJobsAndDestroysThem) {
    const auto owned = std::make_shared<int>(0);
    std::atomic<bool> ran = false;
    Blocker blocker;
    Worker worker({.at_end = AtEnd::discard});
    ASSERT_TRUE(blocker.start(worker));
    ASSERT_TRUE(worker.post([&ran, owned] { ran = true; }));
    std::thread ending([&] { worker.finish(); });
    while (owned.use_count() > 1) std::this_thread::yield();
    blocker.release();
    ending.join();
    EXPECT_FALSE(ran);
    EXPECT_EQ(owned.use_count(), 1);
}

TEST(Worker, RunsADelayedJobAtOnceAtTheEnd) {
    bool ran = false;
    {
        Worker worker;
        ASSERT_TRUE(worker.post_at(Worker::Clock::now() + 1h, [&] { ran = true; }));
    }
    EXPECT_TRUE(ran);
}

TEST(Worker, RunsADelayedJobAfterItsTimeAndAfterImmediateJobs) {
    std::vector<int> order;
    std::promise<void> done;
    const auto due = Worker::Clock::now() + 2ms;
    Worker worker;
    ASSERT_TRUE(worker.post_at(due, [&] {
        order.push_back(2);
        EXPECT_GE(Worker::Clock::now(), due);
        done.set_value();
    }));
    ASSERT_TRUE(worker.post([&] { order.push_back(1); }));
    done.get_future().wait();
    worker.finish();
    EXPECT_EQ(order, (std::vector{1, 2}));
}

TEST(Worker, StartsThreadsAsTheyAreNeeded) {
    std::latch all_running(3);
    Worker worker({.threads = 3});
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(worker.post([&] { all_running.arrive_and_wait(); }));
    worker.finish();  // returns only if the three jobs ran at the same time
}

TEST(Worker, AJobMayPostAnotherUntilTheEndBegins) {
    std::promise<void> done;
    Worker worker;
    ASSERT_TRUE(worker.post([&] { EXPECT_TRUE(worker.post([&] { done.set_value(); })); }));
    done.get_future().wait();
    ASSERT_TRUE(worker.post_at(Worker::Clock::now() + 1h, [&] { EXPECT_FALSE(worker.post([] {})); }));
    worker.finish();
    EXPECT_FALSE(worker.post([] {}));
}

TEST(Worker, LeavesAJobThatDoesNotEndBehind) {
    std::promise<void> ended;
    auto has_ended = ended.get_future();
    Blocker blocker;
    {
        Worker worker({.at_end = AtEnd::discard, .join_timeout = 0ms});
        ASSERT_TRUE(blocker.start(worker));
        worker.post([ended = std::move(ended)] {});  // discarded: the promise breaks
    }
    EXPECT_THROW(has_ended.get(), std::future_error);
    blocker.release();
}

}  // namespace worker_test
}  // namespace takt::os
