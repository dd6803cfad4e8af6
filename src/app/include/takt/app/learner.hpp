// What is learnt of devices while a project runs (gaps: learn): other plans, and a file that keeps it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "takt/app/project.hpp"
#include "takt/app/texts.hpp"
#include "takt/file/learnt.hpp"
#include "takt/line/loop.hpp"
#include "takt/poll/master.hpp"

namespace takt::app {

/// The file beside a project: "plant.learnt.json" for "plant.yaml".
[[nodiscard]] std::string learnt_path(const std::string& project_file);

/// Puts what was learnt before into a project whose devices learn, and adds what is wrong with the file to
/// its findings.
/// @returns where what is learnt may be kept; empty: nowhere, as there is a file that is not understood, or
/// no device that learns
[[nodiscard]] std::string recall_learnt(LoadedProject& loaded, const std::string& project_file);

/// Makes the plans of a running project's lines anew, and writes down what was learnt, on a thread of its
/// own. All members on the loop's thread.
class Learner final : public poll::PlanMaker {
public:
    /// @param path  of the file; empty: nothing is kept
    Learner(line::Loop& loop, const model::Project& project, const Texts& texts, std::string path);
    ~Learner();
    Learner(const Learner&) = delete;
    Learner& operator=(const Learner&) = delete;

    /// @param master  outlives it
    /// @param poke    tells the driver of a line that its engine has something to do
    void follow(poll::Master& master, std::function<void(std::size_t line)> poke);

    void want_plan(std::size_t line, std::vector<model::Learnt> learnt) override;

    /// Something was learnt: it is written down a moment later.
    void note();

    /// Writes down the rest.
    void finish();

private:
    void work();
    void put(std::function<void()> job);
    void save();

    line::Loop& loop_;
    const model::Project& project_;
    Texts texts_;
    std::string path_;
    poll::Master* master_ = nullptr;
    std::function<void(std::size_t)> poke_;
    line::Timer save_timer_;
    bool unsaved_ = false;
    bool complained_ = false;

    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> jobs_;  // at most a plan of each line and a file
    bool ends_ = false;
    std::thread thread_;
};

}  // namespace takt::app
