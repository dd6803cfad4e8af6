// What of a running project survives its end: locals and variables with `retain` (docs/project-file.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "takt/app/texts.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/project.hpp"
#include "takt/poll/master.hpp"
#include "takt/store/retained.hpp"

namespace takt::app {

/// Between the slots of a running project and their file. What is set by command is written at once, what
/// merely changes each second. All on the loop's thread; the writing is a thread of the file.
///
/// Where the file cannot be used, the user is told and the run goes on: nothing is kept then.
class Retention {
public:
    /// What a command waits for at most; further ones are refused.
    static constexpr std::size_t kMostWaiting = 1024;

    /// Reads the file, and says what could not be taken from it.
    /// @returns nullptr where the project retains nothing
    [[nodiscard]] static std::unique_ptr<Retention> open(line::Loop& loop, const Texts& texts,
                                                         const model::Project& project,
                                                         const std::string& path);
    ~Retention();
    Retention(const Retention&) = delete;
    Retention& operator=(const Retention&) = delete;

    /// For poll::Master::Options.
    [[nodiscard]] const std::vector<poll::Restored>& restored() const { return restored_; }

    /// Begins to follow the slots. `slots` outlives it.
    void follow(const value::Store& slots);

    [[nodiscard]] bool retains(value::SlotId slot) const { return kept_.contains(slot); }
    [[nodiscard]] bool full() const { return waiting_.size() >= kMostWaiting; }

    /// Writes what the slot holds now. `then` is told, perhaps later, whether it is on the disk.
    void keep(value::SlotId slot, std::function<void(bool kept)> then);

    /// Writes the rest, and answers all who wait. Nothing is kept afterwards.
    void finish();

private:
    Retention(line::Loop& loop, const Texts& texts);

    /// What was last written of a slot.
    struct Kept {
        value::Value value;
        value::Value wanted;
        bool only_written = false;  // never read: what was wanted of it is all that is known
    };
    struct Waiting {
        std::uint64_t ticket = 0;
        std::function<void(bool)> then;
    };

    void choose(const model::Project& project);
    void load(const std::string& path, const std::vector<value::SlotInfo>& infos);
    void take(const std::string& path, const std::vector<store::Retained>& entries,
              const std::vector<value::SlotInfo>& infos);
    void sweep();
    std::uint64_t put(value::SlotId slot, Kept& kept);
    void settle();

    line::Loop& loop_;
    Texts texts_;
    std::map<value::SlotId, Kept> kept_;
    std::vector<poll::Restored> restored_;
    const value::Store* slots_ = nullptr;
    std::unique_ptr<store::RetainedFile> file_;
    std::deque<Waiting> waiting_;
    std::uint64_t failure_told_ = 0;
    line::Timer sweep_timer_;
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for what the writing thread posted
};

/// Where the retained values of a project are by default: beside it, PLANT.state for PLANT.yaml.
[[nodiscard]] std::string default_state_path(const std::string& project_file);

}  // namespace takt::app
