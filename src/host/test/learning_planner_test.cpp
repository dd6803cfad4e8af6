#include "../learning_planner.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "rig.hpp"
#include "takt/file/learnt.hpp"
#include "tasks.hpp"

namespace takt::host::test {
namespace {

constexpr const char* kLearning = R"(takt: 1
lines:
  - name: main
    transport: simulated
    framing: rtu
    devices:
      - name: Boiler
        address: 1
        poll_period: 100ms
        turnaround: 5ms
        strategy: optimal
        gaps: learn
        variables:
          - {name: Low, type: int, register: 0, read: 0x03}
          - {name: High, type: int, register: 5, read: 0x03}
)";

class LearningPlannerTest : public testing::Test {
protected:
    LearningPlannerTest() {
        std::string pattern = (std::filesystem::temp_directory_path() / "takt-host-XXXXXX").string();
        folder_ = ::mkdtemp(pattern.data());
    }
    ~LearningPlannerTest() override { std::filesystem::remove_all(folder_); }

    std::unique_ptr<LearningPlanner> make(const std::string& path) {
        return std::make_unique<LearningPlanner>(
            path, [this](std::function<void()> task) { tasks_.post(std::move(task)); },
            [this](std::size_t line, plan::LearningPlan plan, std::shared_ptr<const plan::LinePlan> copy) {
                ++plans_;
                rig_->engine->replace_plan(line, std::move(plan), std::move(copy));
            },
            [this](const endpoint::Notice& notice) { notices_.push_back(notice.error->code); });
    }

    /// Polls until the line runs a plan that the learner made. The simulated device has every register.
    void learn(LearningPlanner& learner) {
        rig_ = std::make_unique<Rig>(kLearning, ProjectEngine::Options{.learner = &learner});
        learner.watch(rig_->engine->configuration(), rig_->engine->master());
        const auto& poller = rig_->engine->master().line(0);
        for (int second = 0; second < 30 && poller.plan_revision() == 0; ++second) {
            rig_->run(1s);
            if (const auto events = take_events_of<GapLearnt>(*session()); !events.empty()) tasks_.run_one();
        }
        ASSERT_GT(poller.plan_revision(), 0U);
    }

    Session* session() {
        if (!session_) session_ = rig_->open({.from_beginning = true});
        return session_.get();
    }

    Tasks tasks_;
    std::string folder_;
    std::unique_ptr<Rig> rig_;
    std::unique_ptr<Session> session_;
    int plans_ = 0;
    std::vector<Code> notices_;
};

TEST_F(LearningPlannerTest, APlanForWhatWasLearntRunsAndSnapshotsShowIt) {
    const auto learner = make({});
    learn(*learner);
    EXPECT_EQ(plans_, 1);
    const auto plan = rig_->engine->running_plan(0);
    ASSERT_TRUE(plan);
    ASSERT_EQ(plan->requests.size(), 1U) << "one request bridges what was two";
    EXPECT_EQ(plan->requests[0].quantity, 6);
    rig_->engine->finish(rig_->now);
}

TEST_F(LearningPlannerTest, WhatWasLearntIsInTheFileAtTheEnd) {
    const auto path = folder_ + "/plant.learnt.json";
    const auto learner = make(path);
    learn(*learner);
    rig_->engine->finish(rig_->now);
    std::ifstream file(path);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    auto project = project_of(kLearning);
    const auto recalled = file::recall(text, std::chrono::sys_seconds(std::chrono::hours(500'000)), 0, project);
    EXPECT_TRUE(recalled.whole);
    EXPECT_FALSE(project.lines[0].devices[0].learnt == model::Learnt{}) << text;
    EXPECT_TRUE(notices_.empty());
}

TEST_F(LearningPlannerTest, AFileThatCannotBeWrittenIsReportedOnceAndPollingGoesOn) {
    const auto learner = make(folder_ + "/missing/plant.learnt.json");
    learn(*learner);
    rig_->run(2s);
    tasks_.run_one();
    learner->on_learnt(rig_->now);
    rig_->run(2s);
    tasks_.run_one();
    EXPECT_EQ(notices_, std::vector<Code>{Code::cannot_open});
    rig_->engine->finish(rig_->now);
}

}  // namespace
}  // namespace takt::host::test
