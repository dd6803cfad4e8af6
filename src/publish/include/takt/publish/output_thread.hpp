// The thread of an output: samples into the journal, the journal to the destination.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "takt/base/log.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/publish/output_work.hpp"
#include "takt/publish/sample_queue.hpp"
#include "takt/store/journal.hpp"
#include "takt/store/posix_journal_storage.hpp"

namespace takt::publish {

/// Appends queued samples to a journal, synchronises it, and lets an OutputWork deliver its records. A
/// directory that cannot be opened is tried again; samples then wait in the queue, and are counted as lost
/// where it is full.
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
        Duration stop_limit = std::chrono::seconds(2);  ///< for the destination, from ask_to_stop() on
        Log log;
    };

    OutputThread(Options options, std::unique_ptr<OutputWork> work);
    /// finish()
    ~OutputThread();
    OutputThread(const OutputThread&) = delete;
    OutputThread& operator=(const OutputThread&) = delete;

    [[nodiscard]] const std::string& name() const { return options_.name; }
    [[nodiscard]] SampleQueue& queue() { return queue_; }
    /// Samples are in the queue.
    void wake();
    void state_changed();

    /// What is in the queue becomes durable; the destination has stop_limit to take what waits.
    void ask_to_stop();
    /// ask_to_stop(), and waits for the end. The owner's thread.
    void finish();

    [[nodiscard]] OutputStatus status() const;

private:
    static constexpr Duration kOpenAgain = std::chrono::seconds(5);

    void run();
    void stop(Instant now);
    void wait(Instant until);
    void try_to_open(Instant now);
    void take_queue(Instant now);
    void work(Instant now);
    void find_oldest(Instant now);
    void publish_status(Instant now);
    [[nodiscard]] Instant next_wakeup() const;

    Options options_;
    SampleQueue queue_;
    os::Descriptor bell_;  // an eventfd

    // The thread's.
    std::unique_ptr<OutputWork> work_;
    std::unique_ptr<store::PosixJournalStorage> storage_;
    std::optional<store::Journal> journal_;
    Instant open_again_{};
    std::optional<Error> open_failure_;
    std::uint64_t taken_ = 0;            // samples from the queue
    std::uint64_t appended_before_ = 0;  // counted by the journal when it was opened
    Instant stop_until_ = kNever;        // kNever: it goes on
    bool leaving_ = false;               // the work was stopped
    Instant status_at_{};
    std::optional<std::int64_t> oldest_ns_;

    std::atomic<bool> stopping_ = false;
    std::atomic<bool> state_changed_ = false;
    mutable std::mutex status_mutex_;  // held for a copy only
    OutputStatus status_;              // of the moment when
    std::uint64_t status_taken_ = 0;   // so many samples were taken from the queue
    std::thread thread_;
};

}  // namespace takt::publish
