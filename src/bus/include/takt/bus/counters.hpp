// What happened on a line, to a device, with a request: counts and times.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// Number, least, mean and greatest of a series of durations, in 32 bytes.
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
    std::uint64_t link_lost = 0;
    std::uint64_t exceptions = 0;                        ///< of all codes
    std::array<std::uint32_t, 12> exceptions_by_code{};  ///< codes 1..11; [0]: any other
    TimeStatistics time;  ///< start of the request to the end of its response; answered and exceptions

    void count(const Outcome& outcome);
};

/// What only the line sees.
struct LineCounters : TransactionCounters {
    std::uint64_t broadcasts = 0;
    std::uint64_t foreign_frames = 0;     ///< good frames that answer nothing that was asked
    std::uint64_t late_answers = 0;       ///< of these, answers to requests given up before
    std::uint64_t faults = 0;             ///< bytes that were no frame, counted once a lump
    std::uint64_t unsolicited_bytes = 0;  ///< bytes received while nothing was asked
    std::uint64_t echoes = 0;             ///< own requests heard and dropped
    std::uint64_t not_sent = 0;  ///< given up before a byte was sent: line_busy, link lost, cancelled
};

}  // namespace takt::bus
