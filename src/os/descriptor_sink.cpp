// The descriptor is polled with a short time-out before each write, so that the writing thread notices the
// end of the program also while the reader is stalled.
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>

#include "takt/os/sink.hpp"

namespace takt::os {
namespace {

constexpr int kPollMs = 50;
using Clock = std::chrono::steady_clock;

// Errors of a full disk, a full quota and a limit of the file size: they end when there is space again.
bool is_temporary(int error) {
    return error == ENOSPC || error == EDQUOT || error == EFBIG;
}

// Removes the last `bytes` of a file, if the descriptor's position is its end.
bool cut_end(int descriptor, std::size_t bytes) {
    struct stat status{};
    const off_t position = ::lseek(descriptor, 0, SEEK_CUR);
    if (position < 0 || ::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode) ||
        position != status.st_size)
        return false;
    const off_t end = position - static_cast<off_t>(bytes);
    return ::ftruncate(descriptor, end) == 0 && ::lseek(descriptor, end, SEEK_SET) == end;
}

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

// A part of a line is removed where that is possible. Otherwise the next text begins on a line of its own.
Sink::Written DescriptorSink::failed(std::string_view text, std::size_t done, int error) {
    std::size_t whole = done;
    while (whole > 0 && text[whole - 1] != '\n') --whole;
    in_line_ = (in_line_ && whole == 0) || (whole < done && !cut_end(descriptor_, done - whole));
    return {.bytes = whole, .error = error, .closed = !is_temporary(error)};
}

Sink::Written DescriptorSink::write(std::string_view text) {
    if (in_line_) {
        if (const Written ended = write_all("\n"); ended.error != 0 || ended.closed) return ended;
        in_line_ = false;
    }
    return write_all(text);
}

Sink::Written DescriptorSink::write_all(std::string_view text) {
    std::size_t done = 0;
    auto last_progress = Clock::now();
    while (done < text.size()) {
        pollfd ready{descriptor_, POLLOUT, 0};
        if (::poll(&ready, 1, kPollMs) <= 0) {
            if (is_stalled(last_progress)) return {.bytes = done, .error = ETIMEDOUT, .closed = true};
            continue;
        }
        // A pipe that polls writable takes PIPE_BUF bytes without blocking.
        const auto size = std::min<std::size_t>(text.size() - done, PIPE_BUF);
        const auto count = ::write(descriptor_, text.data() + done, size);
        if (count < 0 && errno != EINTR && errno != EAGAIN) return failed(text, done, errno);
        if (count <= 0) continue;
        done += static_cast<std::size_t>(count);
        last_progress = Clock::now();
    }
    return {.bytes = done, .error = 0, .closed = false};
}

}  // namespace takt::os
