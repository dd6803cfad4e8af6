// Locals and variables with `retain` survive the end of a run (docs/project-file.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sessions/command_executor.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/host/configuration.hpp"
#include "takt/poll/master.hpp"
#include "takt/store/retained.hpp"

namespace takt::host {

/// Between the slots of a running project and their file. A value that was set by a command is written at
/// once, one that merely changed within kSweepEvery.
///
/// Where the file cannot be used, a notice reports it and the run continues; then nothing is kept.
/// The I/O thread only; the file has a writing thread of its own.
class Retention final : public ValuePersistence {
public:
    /// Commands that wait for the disk; further ones are refused.
    static constexpr std::size_t kMostWaiting = 1024;
    static constexpr Duration kSweepEvery = std::chrono::seconds(1);

    /// Runs a task on the I/O thread, soon. Any thread.
    using Post = std::function<void(std::function<void()> task)>;

    /// Opens the file and reads what is in it.
    /// @returns nullptr where the project retains nothing
    [[nodiscard]] static std::unique_ptr<Retention> open(const Configuration& configuration,
                                                         const std::string& path, Post post,
                                                         endpoint::NoticeSink notify);
    ~Retention();
    Retention(const Retention&) = delete;
    Retention& operator=(const Retention&) = delete;

    /// For poll::Master::Options: of open(), or of the last prepare().
    [[nodiscard]] const std::vector<poll::Restored>& restored() const { return restored_; }

    /// Another project is to be applied. A value that it retains and the running one does not is in the
    /// file, if it was retained before: restored() has these values, and watch() uses them. The thread that
    /// applies, while no other does.
    void prepare(const Configuration& next);

    /// Begins to watch the slots of `configuration`, which `slots` holds and which outlives the watching.
    /// After another project was applied: those that it retains, with what is kept of them; the slots of the
    /// call before are still there.
    void watch(const Configuration& configuration, const value::Store& slots);

    [[nodiscard]] bool keeps(value::SlotId slot) const override { return kept_.contains(slot); }
    [[nodiscard]] bool full() const override { return waiting_.size() >= kMostWaiting; }
    void keep(value::SlotId slot, std::function<void(bool kept)> then) override;

    /// Writes what changed since the last sweep, each kSweepEvery.
    void on_tick(Instant t);

    /// Writes the rest and answers every keep(). Nothing is kept afterwards.
    void finish();

private:
    Retention(std::string path, Post post, endpoint::NoticeSink notify)
        : path_(std::move(path)), post_(std::move(post)), notify_(std::move(notify)) {}

    /// The values of a slot that were written last.
    struct Kept {
        value::Value value;
        value::Value wanted;
        bool only_written = false;  // never read: only the wanted value is known
    };
    struct Waiting {
        std::uint64_t ticket = 0;
        std::function<void(bool)> then;
    };

    [[nodiscard]] static std::map<value::SlotId, Kept> chosen(const Configuration& configuration);
    void load(const Configuration& configuration);
    void take(const Configuration& configuration, const std::vector<store::Retained>& entries);
    [[nodiscard]] poll::Restored restored_from(const store::Retained& entry, const value::SlotInfo& info,
                                               value::SlotId slot, bool only_written) const;
    void sweep();
    std::uint64_t put(value::SlotId slot, Kept& kept);
    void settle();

    std::string path_;
    Post post_;
    endpoint::NoticeSink notify_;
    std::map<value::SlotId, Kept> kept_;
    // In the file, but not retained by the project that runs; by name. Changed by watch() only: prepare()
    // reads it on another thread, and watch() follows it.
    std::map<std::string, store::Retained, std::less<>> unclaimed_;
    std::vector<poll::Restored> restored_;
    const value::Store* slots_ = nullptr;
    std::unique_ptr<store::RetainedFile> file_;
    std::deque<Waiting> waiting_;
    std::uint64_t failure_reported_ = 0;
    Instant next_sweep_ = Instant::min();
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for tasks of the writing thread
};

}  // namespace takt::host
