// Lines to a file, a pipe or the terminal, written by a thread of their own: whoever reads them slowly, or
// not at all, never holds up the I/O thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <thread>

namespace takt::app {

/// A queue of at most `limit` bytes before a file descriptor. put() never blocks; what does not fit is
/// dropped and counted, and the number is told in the stream itself by a line made by `gap_line` once there
/// is room again.
///
/// put() may be called from one thread; the descriptor is not closed.
class Output {
public:
    using GapLine = std::string (*)(std::uint64_t missed);

    explicit Output(int descriptor, GapLine gap_line = nullptr, std::size_t limit = 4 << 20);
    ~Output();
    Output(const Output&) = delete;
    Output& operator=(const Output&) = delete;

    /// Queues `text` as it is (with its line end).
    void put(std::string text);

    /// The same for what is said once, at the end: whatever its length, and however much is queued.
    void put_last(std::string text);

    /// Whether that many bytes more would be dropped.
    [[nodiscard]] bool full(std::size_t bytes) const;

    /// Writes what is queued and ends; put() does nothing afterwards. Gives up when nothing was read for
    /// `patience`.
    void finish(std::chrono::milliseconds patience = std::chrono::milliseconds(500));

    /// The reader is gone (closed pipe, full disk): nothing is written any more.
    [[nodiscard]] bool closed() const;

    /// The operating system's number of what ended it so: EPIPE, ENOSPC; 0: nothing did.
    [[nodiscard]] int error() const;

private:
    void queue(std::string text);
    void write_queue();
    [[nodiscard]] bool reader_gone() const;
    [[nodiscard]] bool write_all(const std::string& text);

    const int descriptor_;
    const GapLine gap_line_;
    const std::size_t limit_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::string> queue_;
    std::size_t queued_bytes_ = 0;
    std::uint64_t missed_ = 0;
    bool closed_ = false;
    int error_ = 0;
    bool ending_ = false;
    std::chrono::milliseconds patience_{};
    std::chrono::steady_clock::time_point give_up_at_{};
    std::thread writer_;
};

}  // namespace takt::app
