// Samples on their way from the sampling thread to the thread of an output.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

namespace takt::publish {

/// Samples as one payload (SamplePayload), or the number of samples that are missing in their place.
struct QueuedSamples {
    std::vector<std::uint8_t> payload;  ///< empty: the samples are lost
    std::uint64_t samples = 0;
    std::int64_t first_wall_ns = 0;
    std::int64_t last_wall_ns = 0;
    std::int64_t last_monotonic_ns = 0;
    bool queue_full = false;  ///< of lost samples: they did not fit; else they were lost before
};

/// A queue that is bounded in bytes. What does not fit is replaced by its number, in its place.
///
/// Threads: push() and push_loss() on one thread, take() on another. The mutex is held for a move only.
class SampleQueue {
public:
    /// @param limit  bytes of waiting payloads
    explicit SampleQueue(std::size_t limit) : limit_(limit) {}

    /// @returns whether the queue was empty: the other thread must be woken
    bool push(QueuedSamples samples);
    bool push_loss(std::uint64_t samples, std::int64_t first_wall_ns, std::int64_t last_wall_ns);

    [[nodiscard]] std::optional<QueuedSamples> take();

    /// The way back: the thread that takes asks the one that pushes for the values that the destination
    /// keeps.
    void request_retained() { retained_requested_ = true; }
    [[nodiscard]] bool retained_requested() const { return retained_requested_; }
    /// @returns whether they were requested since the last call
    [[nodiscard]] bool take_retained_request() { return retained_requested_.exchange(false); }

    [[nodiscard]] std::size_t bytes() const;
    struct Pushed {
        std::uint64_t samples = 0;  ///< losses included
        std::uint64_t lost = 0;     ///< of them
    };
    /// Since the queue was made.
    [[nodiscard]] Pushed pushed() const;

private:
    bool append(QueuedSamples samples);

    std::size_t limit_;
    mutable std::mutex mutex_;
    std::deque<QueuedSamples> waiting_;
    std::size_t bytes_ = 0;
    std::atomic<bool> retained_requested_ = false;
    Pushed pushed_;
};

}  // namespace takt::publish
