// Counters and times of a line, a device or a request.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// The number, minimum, mean and maximum of a series of durations, in 32 bytes.
class TimeStatistics {
public:
    void record(Duration sample);
    [[nodiscard]] std::uint64_t count() const { return count_; }
    [[nodiscard]] Duration min() const { return count_ ? min_ : Duration::zero(); }
    [[nodiscard]] Duration max() const { return max_; }
    [[nodiscard]] Duration mean() const;

private:
    std::uint64_t count_ = 0;
    Duration sum_{};
    Duration min_ = Duration::max();
    Duration max_{};
};

/// Outcomes counted by kind.
struct TransactionCounters {
    std::uint64_t sent = 0;
    std::uint64_t answered = 0;  ///< normal responses
    std::uint64_t timeouts = 0;
    std::uint64_t checksums = 0;
    std::uint64_t unexpected = 0;
    std::uint64_t ambiguous = 0;  ///< responses that may have been those to earlier requests
    std::uint64_t link_lost = 0;
    std::uint64_t noisy_answers = 0;                     ///< responses with noise before them
    std::uint64_t noise_bytes = 0;                       ///< and the bytes of this noise
    std::uint64_t exceptions = 0;                        ///< of all codes
    std::array<std::uint32_t, 12> exceptions_by_code{};  ///< codes 1..11; [0]: any other
    TimeStatistics time;  ///< start of the request to the end of its response; answered and exceptions

    void count(const Outcome& outcome);
};

/// Counters that exist for a line only.
struct LineCounters : TransactionCounters {
    std::uint64_t broadcasts = 0;
    std::uint64_t foreign_frames = 0;     ///< good frames that answer no own request
    std::uint64_t late_answers = 0;       ///< responses received after their transaction ended
    std::uint64_t faults = 0;             ///< runs of bytes that were dropped
    std::uint64_t unsolicited_bytes = 0;  ///< bytes received while no request was in flight
    std::uint64_t lengths_off = 0;        ///< tcp: responses with a length in their header that is off by one
    std::uint64_t echoes = 0;             ///< echoes of own requests, dropped
    std::uint64_t not_sent = 0;           ///< ended before a byte was sent: line_busy, link_lost, cancelled
};

}  // namespace takt::bus
