// The outputs of a running project: one thread that samples, and a thread for each output.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/host/session.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/publish/output_thread.hpp"
#include "takt/publish/sample_feed.hpp"
#include "takt/publish/sampler.hpp"

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
/// Threads: all members except the destructor may be called from any thread. Nothing here holds up the
/// host: events that are not read in time are counted as lost, in the stream of every output.
class Outputs final : private SamplerOwner {
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

    /// In the order of the project; the last states after stop(). Outputs that were removed from the project
    /// while samples waited follow, in the state `removed`, until they are in it again.
    [[nodiscard]] std::vector<OutputStatus> status() const;

private:
    struct Running {
        std::string settings;
        std::string directory;  ///< of its journal
        Log log;
        std::shared_ptr<OutputThread> thread;
        std::unique_ptr<SampleFeed> feed;
    };

    std::vector<SampleFeed*> on_configuration(Instant now,
                                              const host::ConfigurationPtr& configuration) override;
    void on_enqueued(std::size_t feed) override;
    void on_state_changed() override;

    void run();
    void ring();
    void wait(Instant until);
    void end_others(const std::vector<std::shared_ptr<OutputThread>>& continued,
                    const std::vector<OutputSetup>& setups);
    void note_removed(const Running& ended);

    // The sampling thread's.
    std::unique_ptr<host::Session> session_;
    MakeSetups make_setups_;
    Sampler sampler_;
    std::vector<Running> running_;

    os::Descriptor bell_;
    std::atomic<bool> stopping_ = false;
    mutable std::mutex threads_mutex_;  // held for a copy only
    std::vector<std::shared_ptr<OutputThread>> threads_;
    std::mutex stop_mutex_;
    std::vector<OutputStatus> removed_;      // with samples that wait, under threads_mutex_
    std::vector<OutputStatus> last_status_;  // after the end, under threads_mutex_
    std::thread thread_;
};

}  // namespace takt::publish
