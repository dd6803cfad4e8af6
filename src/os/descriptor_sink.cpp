// The descriptor is polled with a short time-out before each write, so that the writing thread notices the
// end of the program also while the reader is stalled.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>

#include "takt/os/sink.hpp"

namespace takt::os {
namespace {

constexpr int kPollMs = 50;
using Clock = std::chrono::steady_clock;

}  // namespace

void DescriptorSink::finish_within(std::chrono::milliseconds stall_timeout) {
    ending_since_ = Clock::now();
    stall_timeout_ms_ = stall_timeout.count();
}

bool DescriptorSink::is_stalled(Clock::time_point last_progress) const {
    const auto timeout = stall_timeout_ms_.load();
    return timeout != kNotEnding &&
           Clock::now() - std::max(last_progress, ending_since_.load()) > std::chrono::milliseconds(timeout);
}

// A pipe reports a closed reading end also to a writer that has nothing to write.
bool DescriptorSink::reader_closed() const {
    pollfd pipe{descriptor_, 0, 0};
    return ::poll(&pipe, 1, 0) > 0 && (pipe.revents & POLLERR) != 0;
}

Sink::Written DescriptorSink::write(std::string_view text) {
    std::size_t done = 0;
    auto last_progress = Clock::now();
    while (done < text.size()) {
        pollfd ready{descriptor_, POLLOUT, 0};
        if (::poll(&ready, 1, kPollMs) <= 0) {
            if (is_stalled(last_progress)) return {.bytes = done, .error = 0, .closed = true};
            continue;
        }
        // A pipe that polls writable takes PIPE_BUF bytes without blocking.
        const auto size = std::min<std::size_t>(text.size() - done, PIPE_BUF);
        const auto count = ::write(descriptor_, text.data() + done, size);
        if (count < 0 && errno != EINTR && errno != EAGAIN)
            return {.bytes = done, .error = errno, .closed = true};
        if (count <= 0) continue;
        done += static_cast<std::size_t>(count);
        last_progress = Clock::now();
    }
    return {.bytes = done, .error = 0, .closed = false};
}

}  // namespace takt::os
