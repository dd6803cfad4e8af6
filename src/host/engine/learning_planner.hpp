// Plans and a file for what a running host learns of its devices (docs/planning.md, "Learning gaps").
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "takt/endpoint/notice.hpp"
#include "takt/host/configuration.hpp"
#include "takt/os/worker.hpp"
#include "takt/poll/master.hpp"

namespace takt::host {

/// Makes the plans of lines that learn and writes what was learnt, both on a worker thread, so that neither
/// delays a line. The I/O thread only, except where stated.
class LearningPlanner final : public poll::PlanMaker {
public:
    static constexpr Duration kSaveAfter = std::chrono::milliseconds(200);
    /// Response times change often, and are not worth a write each.
    static constexpr Duration kSaveTimesAfter = std::chrono::seconds(5);
    static constexpr Duration kSaveTimesEvery = std::chrono::minutes(10);

    /// Runs a task on the I/O thread, soon. Any thread.
    using Post = std::function<void(std::function<void()> task)>;
    /// A plan for a line is ready; the receiver hands it to the line.
    using PlanReady = std::function<void(std::size_t line, plan::LearningPlan plan,
                                         std::shared_ptr<const plan::LinePlan> copy)>;

    /// @param path  of the file; empty: nothing is written
    LearningPlanner(std::string path, Post post, PlanReady ready, endpoint::NoticeSink notify);
    LearningPlanner(const LearningPlanner&) = delete;
    LearningPlanner& operator=(const LearningPlanner&) = delete;

    /// The project whose lines learn, and where they run. Plans that were asked for before are dropped.
    void watch(ConfigurationPtr configuration, const poll::Master& master);

    void want_plan(std::size_t line, std::vector<model::Learnt> learnt) override;

    /// Something was learnt: it is written after kSaveAfter.
    void on_learnt(Instant t);
    /// Response times were measured that are worth keeping: they are written after kSaveTimesAfter, from then
    /// on each kSaveTimesEvery, and at the end.
    void on_measured(Instant t);
    void on_tick(Instant t);

    /// Writes the rest and ends the worker.
    void finish(Instant t);

private:
    void save(Instant t);

    std::string path_;
    Post post_;
    PlanReady ready_;
    endpoint::NoticeSink notify_;
    ConfigurationPtr configuration_;
    const poll::Master* master_ = nullptr;
    Instant save_at_ = kNever;
    bool keeps_times_ = false;
    bool failure_reported_ = false;
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for tasks of the worker
    os::Worker worker_;  // at most a plan for each line and a file wait
};

}  // namespace takt::host
