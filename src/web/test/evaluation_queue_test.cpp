#include "evaluation_queue.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace takt::web {
namespace evaluation_queue_test {

TEST(EvaluationQueue, ANewerTurnOfAClientSupersedesItsOlderOne) {
    EvaluationQueue queue(2);
    EvaluationQueue::Turn first(queue, "a");
    EvaluationQueue::Turn other(queue, "b");
    EXPECT_TRUE(first.begin());
    EXPECT_FALSE(first.superseded());
    EvaluationQueue::Turn second(queue, "a");
    EXPECT_TRUE(first.superseded());
    EXPECT_FALSE(other.superseded());
    EXPECT_FALSE(second.superseded());
}

TEST(EvaluationQueue, AWaitingTurnThatIsSupersededDoesNotBegin) {
    EvaluationQueue queue(1);
    EvaluationQueue::Turn running(queue, "a");
    ASSERT_TRUE(running.begin());
    EvaluationQueue::Turn waiting(queue, "b");
    std::atomic<int> begun = -1;
    std::thread thread([&] { begun = waiting.begin() ? 1 : 0; });
    EvaluationQueue::Turn newer(queue, "b");
    thread.join();
    EXPECT_EQ(begun, 0);
}

TEST(EvaluationQueue, HasAtMostThatManyInProgress) {
    EvaluationQueue queue(2);
    std::atomic<int> now = 0;
    std::atomic<int> most = 0;
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&, i] {
            for (int round = 0; round < 200; ++round) {
                EvaluationQueue::Turn turn(queue, std::to_string(i));
                ASSERT_TRUE(turn.begin());
                const int here = ++now;
                int seen = most;
                while (seen < here && !most.compare_exchange_weak(seen, here)) {}
                --now;
            }
        });
    for (auto& thread : threads) thread.join();
    EXPECT_LE(most, 2);
}

}  // namespace evaluation_queue_test
}  // namespace takt::web
