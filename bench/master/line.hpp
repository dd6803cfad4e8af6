// One device at the other end of a paced serial line, or of a TCP connection, in a process of its own.
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::bench {

/// Counts of the device's process.
struct Seen {
    static constexpr std::size_t kMost = 100'000;

    std::atomic<std::uint64_t> requests;
    std::atomic<std::uint64_t> disturbed;  ///< answers that stuttered: nothing is known of the silence behind
    std::atomic<std::size_t> samples;
    std::array<std::int64_t, kMost> idle_ns;  ///< from the end of an answer to the next request, less t3.5
    std::atomic<std::uint16_t> port;          ///< TCP
};

/// Unit 1: a register holds its own address. It answers t3.5 after the request (TCP: at once).
///
/// Serial: the request lasts as long as its characters, from the moment its first is there; each character of
/// the answer is handed over when its stop bit would be over. A line does not stutter, a process does: it
/// asks for real-time priority, and gets it where it may.
class FarEnd {
public:
    /// A pseudo-terminal.
    FarEnd(const wire::CharacterFormat& format, int processor);
    /// TCP on 127.0.0.1.
    explicit FarEnd(int processor);
    ~FarEnd();
    FarEnd(const FarEnd&) = delete;
    FarEnd& operator=(const FarEnd&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] std::uint16_t port() const { return seen_->port; }
    [[nodiscard]] std::uint64_t requests() const { return seen_->requests; }
    [[nodiscard]] std::uint64_t disturbed() const { return seen_->disturbed; }
    /// Ascending.
    [[nodiscard]] std::vector<Duration> idle() const;

private:
    void share();

    Seen* seen_ = nullptr;
    std::string path_;
    int near_ = -1;  // keeps the pseudo-terminal as it is
    pid_t process_ = -1;
};

}  // namespace takt::bench
