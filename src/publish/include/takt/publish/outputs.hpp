// The outputs of a running project: one thread that samples, and a thread for each output.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/host/session.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/publish/output_thread.hpp"
#include "takt/publish/sample_feed.hpp"

namespace takt::publish {

/// An output of a configuration, before it runs.
struct OutputSetup {
    /// Everything that the thread and its work depend on. An output with the same name and settings continues
    /// over a change of the project, with its connection.
    std::string settings;
    OutputThread::Options thread;
    std::vector<SelectedSlot> selected;
    std::function<std::unique_ptr<OutputWork>()> make_work;
};

/// Samples the values of a host for all outputs, until it is stopped.
///
/// Threads: all members may be called from any thread, but for the destructor. Nothing here holds up the
/// host: events that are not read in time are counted as lost, in the stream of every output.
class Outputs {
public:
    /// The outputs of a configuration. Called on the sampling thread.
    using MakeSetups = std::function<std::vector<OutputSetup>(const host::ConfigurationPtr& configuration)>;

    /// @param session  with events
    Outputs(std::unique_ptr<host::Session> session, MakeSetups make_setups);
    /// stop()
    ~Outputs();
    Outputs(const Outputs&) = delete;
    Outputs& operator=(const Outputs&) = delete;

    /// Samples what the session still has, makes it durable and gives the destinations the time of
    /// OutputThread::Options::stop_limit. To be called after ProjectHost::stop(). A second call does nothing.
    void stop();

    /// In the order of the project; the last states after stop().
    [[nodiscard]] std::vector<OutputStatus> status() const;

private:
    /// How long samples are collected before they go to the journal together.
    static constexpr Duration kCollect = std::chrono::milliseconds(50);

    struct Running {
        std::string settings;
        std::shared_ptr<OutputThread> thread;
        std::unique_ptr<SampleFeed> feed;
    };

    void run();
    void wait(Instant until);
    void follow_configuration(Instant now);
    void read_events(Instant now);
    void on_event(const host::Event& event);
    void count_lost(Instant now);
    void sample_due(Instant now);
    void deliver_current(Instant now);
    [[nodiscard]] std::optional<host::Snapshot> take_snapshot(Instant now);
    void flush();
    void set_clocks(Instant now);
    [[nodiscard]] Instant next_wakeup() const;

    // The sampling thread's.
    std::unique_ptr<host::Session> session_;
    MakeSetups make_setups_;
    host::ConfigurationPtr configuration_;
    std::vector<Running> running_;
    Instant flush_at_ = kNever;
    bool current_due_ = false;  // the current state of all values is to be delivered
    Instant last_event_;        // time of the last event that was read
    std::uint64_t missed_ = 0;  // of the session, counted so far
    std::uint64_t lost_ = 0;    // reported by the host, not counted yet

    os::Descriptor bell_;
    std::atomic<bool> stopping_ = false;
    mutable std::mutex threads_mutex_;  // held for a copy only
    std::vector<std::shared_ptr<OutputThread>> threads_;
    std::mutex stop_mutex_;
    std::vector<OutputStatus> last_status_;  // after the end, under threads_mutex_
    std::thread thread_;
};

}  // namespace takt::publish
