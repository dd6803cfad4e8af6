// Trial reads and plans without a line. What trials prove is tested in learning_test.cpp.
#include "learning/gap_learner.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace gap_learner_test {

struct Fresh final : FreshnessProbe {
    Freshness freshness(std::size_t, wire::Function, const model::ItemRange&, Instant) const override {
        return state;
    }
    Freshness state = Freshness::good;
};

struct Maker final : PlanMaker {
    void want_plan(std::size_t line, std::vector<model::Learnt> known) override {
        EXPECT_EQ(line, 0U);
        ++wanted;
        learnt = std::move(known);
    }
    int wanted = 0;
    std::vector<model::Learnt> learnt;
};

/// Two registers with a gap of one between them.
model::Project described() {
    auto made = project({device(1, {int16("a", 0).read(3), int16("b", 2).read(3)})});
    auto& learning = made.lines[0].devices[0];
    learning.strategy = model::Strategy::optimal;
    learning.gaps = model::Gaps::learn;
    return made;
}

bus::Outcome outcome(bus::Status status, Instant t, std::uint8_t exception = 0) {
    return {.status = status, .exception = exception, .sent = true, .sent_at = t, .ended_at = t};
}

TEST(GapLearner, BeginsWithoutTheGapAndTriesIt) {
    const auto project = described();
    GapLearner learner(project, 0, nullptr);
    EXPECT_EQ(learner.plan().requests.size(), 2U);
    learner.update(at(0s));
    EXPECT_EQ(learner.next_plan(), nullptr);
    const auto* const trial = learner.next_trial(at(0s), Fresh{});
    ASSERT_NE(trial, nullptr);
    EXPECT_EQ(trial->read.start, DataAddress{0});
    EXPECT_EQ(trial->read.quantity, 3);
    EXPECT_FALSE(learner.in_flight());
    learner.start(at(0s));
    EXPECT_TRUE(learner.in_flight());
}

TEST(GapLearner, AnAcceptedGapLeadsToAnotherPlan) {
    for (const bool with_maker : {false, true}) {
        const auto project = described();
        Maker maker;
        GapLearner learner(project, 0, with_maker ? &maker : nullptr);
        learner.update(at(0s));
        ASSERT_NE(learner.next_trial(at(0s), Fresh{}), nullptr);
        learner.start(at(0s));
        learner.end(outcome(bus::Status::ok, at(1s)));
        const auto event = learner.take_event();
        ASSERT_TRUE(event);
        EXPECT_EQ(event->kind, GapEvent::Kind::confirmed);
        learner.update(at(1s));
        learner.update(at(1s));
        if (with_maker) {
            EXPECT_EQ(maker.wanted, 1) << "until it is delivered";
            EXPECT_EQ(learner.next_plan(), nullptr);
            learner.offer(plan::learning_plan(project, 0, maker.learnt));
        }
        ASSERT_NE(learner.next_plan(), nullptr);
        EXPECT_EQ(learner.next_plan()->requests.size(), 1U);
        EXPECT_EQ(learner.plan().requests.size(), 2U) << "until it is swapped in";
        EXPECT_EQ(learner.swap_plan().requests.size(), 2U);
        learner.plan_runs(at(2s));
        EXPECT_EQ(learner.plan().requests.size(), 1U);
        learner.update(at(3s));
        EXPECT_EQ(learner.next_plan(), nullptr);
        EXPECT_EQ(maker.wanted, with_maker ? 1 : 0);
    }
}

TEST(GapLearner, WithoutFreshValuesThereIsNoTrial) {
    const auto project = described();
    GapLearner learner(project, 0, nullptr);
    learner.update(at(0s));
    Fresh probe;
    probe.state = Freshness::not_yet;
    EXPECT_EQ(learner.next_trial(at(0s), probe), nullptr);
}

TEST(GapLearner, ATrialThatWaitedForTwoSecondsDelaysPolling) {
    struct Case {
        Duration waited;
        bool overloaded;
        Urgency urgency;
    };
    const Case kCases[] = {{1999ms, false, Urgency::background},
                           {1999ms, true, Urgency::background},
                           {2s, false, Urgency::background},
                           {2s, true, Urgency::overdue}};
    for (const auto& c : kCases) {
        const auto project = described();
        GapLearner learner(project, 0, nullptr);
        learner.update(at(10s));
        ASSERT_NE(learner.next_trial(at(10s), Fresh{}), nullptr);
        EXPECT_EQ(learner.latest_start(at(10s)), at(12s));
        ASSERT_NE(learner.next_trial(at(10s + c.waited), Fresh{}), nullptr);
        EXPECT_EQ(learner.latest_start(at(10s + c.waited)), at(12s)) << "counted from the first moment";
        EXPECT_EQ(learner.candidate(at(10s + c.waited), c.overloaded).urgency, c.urgency);
        Fresh probe;
        probe.state = Freshness::not_yet;
        EXPECT_EQ(learner.next_trial(at(13s), probe), nullptr);
        EXPECT_EQ(learner.latest_start(at(14s)), at(16s)) << "no trial waited meanwhile";
    }
}

TEST(GapLearner, OnlyRefusalsCountAgainstAGap) {
    for (const int code : {1, 2, 3, 4}) EXPECT_TRUE(GapLearner::refuses(static_cast<std::uint8_t>(code)));
    for (const int code : {0, 5, 6, 10, 11})
        EXPECT_FALSE(GapLearner::refuses(static_cast<std::uint8_t>(code)));
    struct Case {
        bus::Status status;
        std::uint8_t exception;
        bool refused;
    };
    const Case kCases[] = {{bus::Status::exception, 2, true},
                           {bus::Status::exception, 6, false},
                           {bus::Status::timeout, 0, false}};
    for (const auto& c : kCases) {
        const auto project = described();
        GapLearner learner(project, 0, nullptr);
        learner.update(at(0s));
        Instant now = at(0s);
        for (unsigned i = 0; i < Learning::kRefusals; ++i, now += 1s) {
            ASSERT_NE(learner.next_trial(now, Fresh{}), nullptr);
            learner.start(now);
            learner.end(outcome(c.status, now, c.exception));
            if (const Instant wakeup = learner.wakeup(now); wakeup != kNever) now = std::max(now, wakeup);
        }
        const auto event = learner.take_event();
        EXPECT_EQ(event.has_value() && event->kind == GapEvent::Kind::refused, c.refused);
    }
}

TEST(GapLearner, ADoubtedGapLeavesThePlan) {
    const auto project = described();
    GapLearner learner(project, 0, nullptr);
    learner.update(at(0s));
    ASSERT_NE(learner.next_trial(at(0s), Fresh{}), nullptr);
    learner.start(at(0s));
    learner.end(outcome(bus::Status::ok, at(1s)));
    learner.update(at(1s));
    static_cast<void>(learner.swap_plan());
    learner.plan_runs(at(1s));
    ASSERT_EQ(learner.plan().requests.size(), 1U);
    const model::ItemRange kGap[] = {{1, 1}};
    learner.doubt(0, Function::read_holding_registers, kGap);
    learner.update(at(2s));
    ASSERT_NE(learner.next_plan(), nullptr);
    EXPECT_EQ(learner.next_plan()->requests.size(), 2U);
}

}  // namespace gap_learner_test
}  // namespace takt::poll::test
