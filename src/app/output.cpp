// The descriptor is polled with a short limit before each write, so that the writer sees the end of the
// program also while nobody reads; it is never switched to non-blocking, which would change it for every
// process that shares it.
#include "takt/app/output.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <utility>

namespace takt::app {
namespace {

constexpr int kPollMs = 50;

}  // namespace

Output::Output(int descriptor, GapLine gap_line, std::size_t limit)
    : descriptor_(descriptor), gap_line_(gap_line), limit_(limit), writer_([this] { write_queue(); }) {}

Output::~Output() {
    finish();
}

void Output::finish(std::chrono::milliseconds patience) {
    if (!writer_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
        patience_ = patience;
        give_up_at_ = std::chrono::steady_clock::now() + patience;
    }
    changed_.notify_one();
    writer_.join();
    closed_ = true;
}

void Output::put(std::string text) {
    {
        const std::lock_guard lock(mutex_);
        if (closed_) return;
        if (queued_bytes_ + text.size() > limit_) {
            ++missed_;
            return;
        }
        queue(std::move(text));
    }
    changed_.notify_one();
}

void Output::put_last(std::string text) {
    {
        const std::lock_guard lock(mutex_);
        if (closed_) return;
        queue(std::move(text));
    }
    changed_.notify_one();
}

void Output::queue(std::string text) {
    if (missed_ > 0 && gap_line_) {
        queue_.push_back(gap_line_(missed_));
        queued_bytes_ += queue_.back().size();
    }
    missed_ = 0;
    queued_bytes_ += text.size();
    queue_.push_back(std::move(text));
}

bool Output::full(std::size_t bytes) const {
    const std::lock_guard lock(mutex_);
    return queued_bytes_ + bytes > limit_;
}

bool Output::closed() const {
    const std::lock_guard lock(mutex_);
    return closed_ || reader_gone();
}

// A pipe tells it also to a writer that has nothing to say just now.
bool Output::reader_gone() const {
    pollfd pipe{descriptor_, 0, 0};
    return ::poll(&pipe, 1, 0) > 0 && (pipe.revents & POLLERR) != 0;
}

int Output::error() const {
    const std::lock_guard lock(mutex_);
    return error_;
}

void Output::write_queue() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [this] { return ending_ || !queue_.empty(); });
        if (queue_.empty()) return;
        const std::string text = std::move(queue_.front());
        queue_.pop_front();
        lock.unlock();
        const bool written = write_all(text);
        lock.lock();
        queued_bytes_ -= text.size();
        if (!written) {
            closed_ = true;
            queue_.clear();
            return;
        }
    }
}

bool Output::write_all(const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
        pollfd ready{descriptor_, POLLOUT, 0};
        if (::poll(&ready, 1, kPollMs) == 0) {
            const std::lock_guard lock(mutex_);
            if (ending_ && std::chrono::steady_clock::now() > give_up_at_) return false;
            continue;
        }
        // A pipe that polls writable takes PIPE_BUF bytes without blocking.
        const auto size = std::min<std::size_t>(text.size() - done, PIPE_BUF);
        const auto count = ::write(descriptor_, text.data() + done, size);
        if (count < 0 && errno != EINTR && errno != EAGAIN) {
            const std::lock_guard lock(mutex_);
            error_ = errno;
            return false;
        }
        if (count <= 0) continue;
        done += static_cast<std::size_t>(count);
        const std::lock_guard lock(mutex_);
        if (ending_) give_up_at_ = std::chrono::steady_clock::now() + patience_;
    }
    return true;
}

}  // namespace takt::app
