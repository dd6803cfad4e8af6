#include "engine/learning_planner.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "folder.hpp"
#include "projects.hpp"
#include "rig.hpp"
#include "takt/file/learnt.hpp"
#include "tasks.hpp"

namespace takt::host::test {
namespace learning_planner_test {

const std::string kLearning =
    project_with(line_of("main", device_of("Boiler", 1, variable_of("Low", 0) + variable_of("High", 5),
                                           ", strategy: optimal, gaps: learn")));

class LearningPlannerTest : public testing::Test {
protected:
    std::unique_ptr<LearningPlanner> make(const std::string& path) {
        return std::make_unique<LearningPlanner>(
            path, [this](std::function<void()> task) { tasks_.post(std::move(task)); },
            [this](std::size_t line, plan::LearningPlan plan, std::shared_ptr<const plan::LinePlan> copy) {
                ++plans_;
                rig_->engine->replace_plan(line, std::move(plan), std::move(copy));
            },
            [this](const endpoint::Notice& notice) { notices_.push_back(notice.error->code); });
    }

    /// Polls until the line runs a plan for what was learnt. The simulated device refuses the registers of
    /// the gap. In virtual time the poller always wants a plan within the seconds in which it learns.
    void learn(LearningPlanner& planner) {
        rig_ = std::make_unique<Rig>(kLearning, ProjectEngine::Options{.learner = &planner});
        planner.watch(rig_->engine->configuration(), rig_->engine->master());
        const auto session = rig_->open({.from_beginning = true});
        const auto& poller = rig_->engine->master().line(0);
        rig_->run(30s);
        ASSERT_FALSE(take_events_of<GapLearnt>(*session).empty());
        while (poller.plan_revision() == 0) {
            tasks_.run_one();
            rig_->run(1s);
        }
    }

    takt::test::Tasks tasks_;
    takt::test::Folder folder_;
    std::unique_ptr<Rig> rig_;
    int plans_ = 0;
    std::vector<Code> notices_;
};

TEST_F(LearningPlannerTest, APlanForWhatWasLearntRunsAndSnapshotsShowIt) {
    const auto learner = make({});
    learn(*learner);
    EXPECT_EQ(rig_->engine->master().line(0).plan_revision(), static_cast<std::uint64_t>(plans_));
    const auto buffer = rig_->snapshot({.statistics = true, .plan = true, .learnt = true}, 8);
    ASSERT_FALSE(buffer->too_small);
    const auto& line = buffer->snapshot.lines.at(0);
    ASSERT_TRUE(line.plan);
    EXPECT_EQ(line.plan->requests.size(), 2U) << "the gap is refused: nothing bridges it";
    EXPECT_EQ(line.requests.size(), 2U);
    ASSERT_EQ(line.learnt.size(), 1U);
    const auto& refused = line.learnt[0].refused[static_cast<std::size_t>(wire::Area::holding_register)];
    ASSERT_EQ(refused.size(), 1U);
    EXPECT_EQ(refused[0].items.first, 1);
    EXPECT_EQ(refused[0].items.last, 4);
    rig_->engine->finish(rig_->now);
}

TEST_F(LearningPlannerTest, ASnapshotWithTooLittleMemoryForWhatWasLearntSaysSoAndNoneAllocates) {
    const auto learner = make({});
    learn(*learner);
    const auto before = takt::test::allocations().count;
    const auto small = rig_->snapshot({.learnt = true}, 0);
    EXPECT_TRUE(small->too_small);
    const auto large = rig_->snapshot({.learnt = true}, more_memory(0));
    EXPECT_FALSE(large->too_small);
    EXPECT_EQ(takt::test::allocations().count, before);
    EXPECT_EQ(large->snapshot.lines.at(0).learnt, rig_->engine->master().line(0).learnt(rig_->now));
    rig_->engine->finish(rig_->now);
}

TEST_F(LearningPlannerTest, WhatWasLearntIsInTheFileAtTheEnd) {
    const auto path = folder_ / "plant.learnt.json";
    const auto learner = make(path);
    learn(*learner);
    rig_->engine->finish(rig_->now);
    std::ifstream file(path);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    auto project = project_of(kLearning);
    const auto recalled =
        file::recall(text, std::chrono::sys_seconds(std::chrono::hours(500'000)), 0, project);
    EXPECT_TRUE(recalled.whole);
    EXPECT_FALSE(project.lines[0].devices[0].learnt == model::Learnt{}) << text;
    EXPECT_TRUE(notices_.empty());
}

TEST_F(LearningPlannerTest, ResponseTimesAreKeptForADeviceThatLearnsThem) {
    for (const bool learns : {false, true}) {
        auto text = project_with(line_of("main", device_of("Boiler", 1, variable_of("Low", 0), {})));
        const std::string written = "turnaround: 5ms";
        text.replace(text.find(written), written.size(), learns ? "turnaround: learn" : "comment: slow");
        const auto path = folder_ / (learns ? "learns.json" : "plain.json");
        const auto learner = make(path);
        rig_ = std::make_unique<Rig>(text, ProjectEngine::Options{.learner = learner.get()});
        learner->watch(rig_->engine->configuration(), rig_->engine->master());
        rig_->run(150s);
        const auto measured = rig_->engine->master().line(0).measured(0);
        EXPECT_GT(measured.exchanges, 0U);
        rig_->engine->finish(rig_->now);
        std::ifstream file(path);
        ASSERT_EQ(file.is_open(), learns) << "a healthy device that learns nothing";
        if (!file.is_open()) continue;
        const std::string kept(std::istreambuf_iterator<char>(file), {});
        auto project = project_of(text);
        ASSERT_TRUE(file::recall(kept, std::chrono::sys_seconds{}, 0, project).whole) << kept;
        EXPECT_EQ(project.lines[0].devices[0].times.measured.exchanges, measured.exchanges);
    }
}

TEST_F(LearningPlannerTest, AFileThatCannotBeWrittenIsReportedOnceAndPollingGoesOn) {
    const auto learner = make(folder_ / "missing/plant.learnt.json");
    learn(*learner);
    rig_->run(30s);
    while (notices_.empty()) tasks_.run_one();
    learner->on_learnt(rig_->now);
    rig_->run(2s);
    tasks_.run_one();
    EXPECT_EQ(notices_, std::vector<Code>{Code::cannot_open});
    rig_->engine->finish(rig_->now);
}

}  // namespace learning_planner_test
}  // namespace takt::host::test
