// The thread of an output: samples into the journal, the journal to the destination.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include "takt/base/log.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/publish/output_engine.hpp"
#include "takt/publish/output_work.hpp"

namespace takt::publish {

/// Runs an OutputEngine with a journal in a directory.
///
/// Threads: queue().push…() on one other thread; wake(), state_changed(), ask_to_stop() and status() on any.
/// The thread waits for the disk and for nothing else.
class OutputThread {
public:
    struct Options {
        std::string name;       ///< of the output, and of its destination in the journal
        std::string directory;  ///< of the journal; created if it does not exist
        store::JournalOptions journal;
        std::size_t queue_bytes = 4U << 20;
        Duration stop_limit = std::chrono::seconds(2);  ///< as OutputEngine::Options
        std::function<void()> wake_sampler;             ///< likewise
        Log log;
    };

    OutputThread(Options options, std::unique_ptr<OutputWork> work);
    /// finish()
    ~OutputThread();
    OutputThread(const OutputThread&) = delete;
    OutputThread& operator=(const OutputThread&) = delete;

    [[nodiscard]] const std::string& name() const { return engine_.name(); }
    [[nodiscard]] SampleQueue& queue() { return engine_.queue(); }
    /// Samples are in the queue.
    void wake();
    void state_changed();

    /// What is in the queue becomes durable; the destination has stop_limit to take what waits.
    void ask_to_stop();
    /// ask_to_stop(), and waits for the end. The owner's thread.
    void finish();

    [[nodiscard]] OutputStatus status() const;

private:
    /// A disk that does not answer for this time is reported.
    static constexpr Duration kDiskHangs = std::chrono::seconds(2);
    static constexpr Instant::rep kWaiting = std::numeric_limits<Instant::rep>::max();

    void run();
    void wait(Instant until);
    /// Does not return while the disk does not answer.
    void step(Instant now);

    os::Descriptor bell_;  // an eventfd
    OutputEngine engine_;
    std::atomic<bool> stopping_ = false;
    std::atomic<bool> state_changed_ = false;
    std::atomic<Instant::rep> step_began_ = kWaiting;  // kWaiting: between two steps
    std::thread thread_;
};

}  // namespace takt::publish
