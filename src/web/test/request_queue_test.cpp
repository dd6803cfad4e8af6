#include "http/request_queue.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace takt::web {
namespace request_queue_test {

using Ids = std::vector<RequestQueue::Id>;
using enum RequestQueue::Pushed;

/// 4 threads for quick requests, of which one visitor gets 2; 2 for planning, 1.
RequestQueue::Limits limits() {
    RequestQueue::Limits limits{.waiting = 6, .waiting_of_visitor = 4};
    limits.executing = {{{4, 2}, {2, 1}, {2, 1}}};
    return limits;
}

struct RequestQueueTest : testing::Test {
    RequestQueue queue{limits()};
    RequestQueue::Id last = 0;

    RequestQueue::Pushed push(const std::string& visitor, Work work = Work::quick,
                              const std::string& superseded_by = "") {
        return queue.push({++last, work, visitor, superseded_by});
    }
    Ids start_all() {
        Ids started;
        while (const auto id = queue.next()) started.push_back(*id);
        return started;
    }
};

TEST_F(RequestQueueTest, OneVisitorGetsPartOfTheThreads) {
    for (int i = 0; i < 4; ++i) EXPECT_EQ(push("a"), accepted);
    EXPECT_EQ(start_all(), (Ids{1, 2}));
    EXPECT_EQ(push("b"), accepted);
    EXPECT_EQ(push("b"), accepted);
    EXPECT_EQ(start_all(), (Ids{5, 6}));
    queue.remove(1);
    EXPECT_EQ(start_all(), (Ids{3}));
}

TEST_F(RequestQueueTest, EachKindOfWorkHasItsThreads) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(push("a", Work::planning), accepted);
    EXPECT_EQ(start_all(), (Ids{1}));
    EXPECT_EQ(push("a"), accepted);
    EXPECT_EQ(push("a", Work::device), accepted);
    EXPECT_EQ(push("b", Work::planning), accepted);
    EXPECT_EQ(start_all(), (Ids{6, 4, 5})) << "b has none in execution";
    EXPECT_EQ(push("c", Work::planning), accepted);
    EXPECT_EQ(start_all(), Ids{}) << "two are executed";
}

// c has nothing in execution, so it comes before the older ones of a.
TEST_F(RequestQueueTest, TheVisitorWithTheFewestComesFirst) {
    for (const auto* visitor : {"a", "b", "b"}) EXPECT_EQ(push(visitor), accepted);
    EXPECT_EQ(push("d"), accepted);
    EXPECT_EQ(start_all(), (Ids{1, 2, 4, 3}));
    EXPECT_EQ(push("a"), accepted);
    EXPECT_EQ(push("c"), accepted);
    EXPECT_EQ(start_all(), Ids{});
    queue.remove(4);
    EXPECT_EQ(start_all(), (Ids{6}));
}

TEST_F(RequestQueueTest, RefusesWhatMayNotWait) {
    struct Case {
        const char* visitor;
        RequestQueue::Pushed pushed;
    };
    const std::vector<Case> cases{
        {"a", accepted}, {"a", accepted},  // executed
        {"a", accepted}, {"a", accepted}, {"a", accepted}, {"a", accepted}, {"a", visitor_full},
        {"b", accepted}, {"b", accepted},  // executed
        {"b", accepted}, {"b", accepted}, {"b", full},     {"c", full},     {"a", visitor_full},
    };
    for (std::size_t i = 0; i < cases.size(); ++i) {
        EXPECT_EQ(push(cases[i].visitor), cases[i].pushed) << i;
        static_cast<void>(start_all());
    }
    EXPECT_EQ(queue.waiting(), 6u);
    // A thread is free for it, so it need not wait.
    EXPECT_EQ(push("a", Work::planning), accepted);
}

TEST_F(RequestQueueTest, ANewerRequestSupersedesWaitingAndExecutedOnes) {
    EXPECT_EQ(push("a", Work::planning, "a 1"), accepted);
    static_cast<void>(start_all());
    EXPECT_EQ(push("a", Work::planning, "a 1"), accepted);
    EXPECT_EQ(queue.superseded(), (Ids{1}));
    EXPECT_EQ(push("a", Work::planning, "a 2"), accepted);
    EXPECT_EQ(queue.superseded(), Ids{});
    EXPECT_EQ(push("a", Work::planning, "a 1"), accepted);
    EXPECT_EQ(queue.superseded(), (Ids{2, 1}));
    EXPECT_EQ(start_all(), Ids{});
    queue.cut_short(2);
    EXPECT_EQ(start_all(), (Ids{2})) << "it is answered without waiting for its turn";
    queue.remove(2);
    queue.remove(1);
    EXPECT_EQ(start_all(), (Ids{3}));
    EXPECT_EQ(push("a"), accepted);
    EXPECT_EQ(queue.superseded(), Ids{});
}

TEST_F(RequestQueueTest, WhatIsNeverSupersededKeepsItsTurn) {
    EXPECT_EQ(push("a", Work::device), accepted);
    EXPECT_EQ(push("a", Work::device), accepted);
    EXPECT_EQ(start_all(), (Ids{1}));
    queue.cut_short(2);
    EXPECT_EQ(start_all(), Ids{}) << "it would hold a thread of the quick ones";
}

TEST_F(RequestQueueTest, ForgetsWhoseClientHasGone) {
    EXPECT_EQ(push("a", Work::planning), accepted);
    static_cast<void>(start_all());
    EXPECT_EQ(push("a", Work::planning), accepted);
    EXPECT_EQ(push("a", Work::planning), accepted);
    queue.remove(2);
    queue.remove(77);
    queue.remove(1);
    EXPECT_EQ(start_all(), (Ids{3}));
}

}  // namespace request_queue_test
}  // namespace takt::web
