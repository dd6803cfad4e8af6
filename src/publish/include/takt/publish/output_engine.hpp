// An output without its thread: samples into the journal, the journal to the destination.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "takt/base/log.hpp"
#include "takt/publish/output_work.hpp"
#include "takt/publish/sample_queue.hpp"
#include "takt/publish/wall_clock.hpp"
#include "takt/store/journal.hpp"

namespace takt::publish {

class DeliveryPace;
class OutputLog;

/// Appends queued samples to a journal, synchronises it, and lets an OutputWork deliver its records. A
/// storage that cannot be opened is tried again; samples then wait in the queue, and are counted as lost
/// where it is full.
///
/// Reads no clock and waits for the storage only, so that tests and the simulation drive it by hand.
///
/// Threads: queue().push…() on one other thread; status() on any; all others on the owner's.
class OutputEngine {
public:
    struct Options {
        std::string name;  ///< of the output, and of its destination in the journal
        store::JournalOptions journal;
        std::size_t queue_bytes = 4U << 20;
        /// For the destination to take what waits, after the journal was synchronised for stop().
        Duration stop_limit = std::chrono::seconds(2);
        /// Called again until it succeeds.
        std::function<Result<std::unique_ptr<store::JournalStorage>>()> open_storage;
        /// The queue has a request for the thread that fills it; may be empty.
        std::function<void()> wake_sampler;
        WallClock wall_ns = system_wall_ns;
        Log log;
    };

    OutputEngine(Options options, std::unique_ptr<OutputWork> work);
    OutputEngine(const OutputEngine&) = delete;
    OutputEngine& operator=(const OutputEngine&) = delete;
    /// Does not write: see close().
    ~OutputEngine();

    [[nodiscard]] const std::string& name() const { return options_.name; }
    [[nodiscard]] SampleQueue& queue() { return queue_; }

    /// Does what is due. To be called when samples are in the queue, when a descriptor is readable, and at
    /// next_wakeup().
    void step(Instant now);
    [[nodiscard]] Instant next_wakeup() const;
    /// To wait for. Valid until the next step().
    [[nodiscard]] std::span<const int> descriptors() const;
    void on_state_changed(Instant now);

    /// Begins the orderly end with the next step(): what is in the queue becomes durable, and the destination
    /// has stop_limit to take what waits.
    void stop() {
        if (end_ == End::no) end_ = End::asked;
    }
    /// After stop(): close() is to be called.
    [[nodiscard]] bool finished(Instant now) const;
    /// Writes what is left. After it only status() may be called.
    void close(Instant now);

    [[nodiscard]] OutputStatus status() const;

private:
    static constexpr Duration kOpenAgain = std::chrono::seconds(5);

    /// The steps of the orderly end.
    enum class End : std::uint8_t {
        no,
        asked,
        durable,     ///< what was in the queue is on the disk
        delivering,  ///< until stop_until_
        leaving      ///< the work was stopped
    };

    void try_to_open(Instant now);
    [[nodiscard]] Result<store::Journal> open(Instant now);
    void take_queue(Instant now);
    void work(Instant now);
    void advance_stop(Instant now);
    void find_oldest(Instant now);
    void publish_status(Instant now);

    Options options_;
    SampleQueue queue_;
    std::unique_ptr<store::JournalStorage> storage_;  // outlives the journal
    std::optional<store::Journal> journal_;           // outlives the work
    std::unique_ptr<OutputWork> work_;
    std::unique_ptr<OutputLog> output_log_;
    std::unique_ptr<DeliveryPace> pace_;
    Instant open_again_{};
    std::optional<Error> open_failure_;
    std::uint64_t taken_ = 0;            // samples from the queue
    std::uint64_t taken_lost_ = 0;       // of them, lost before
    std::uint64_t appended_before_ = 0;  // counted by the journal when it was opened
    std::uint64_t dropped_before_ = 0;   // likewise
    End end_ = End::no;
    Instant stop_until_ = kNever;
    Instant status_at_{};
    std::optional<std::int64_t> oldest_ns_;

    mutable std::mutex status_mutex_;  // held for a copy only
    OutputStatus status_;              // of the moment when
    std::uint64_t status_taken_ = 0;   // so many samples were taken from the queue
    std::uint64_t status_lost_ = 0;    // of them, lost before
};

}  // namespace takt::publish
