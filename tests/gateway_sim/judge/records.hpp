// The records and cursors on the disk, read by the judge itself.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/engine.hpp"

namespace takt::gatewaysim {

struct GapFacts {
    std::uint16_t cause = 0;  ///< as stored
    std::int64_t first_wall_ns = 0;
    std::int64_t last_wall_ns = 0;
    friend bool operator==(const GapFacts&, const GapFacts&) = default;
};

struct RecordFacts {
    std::uint64_t sequence = 0;
    std::uint64_t epoch = 0;
    std::uint64_t samples = 0;
    std::uint64_t samples_before = 0;
    std::int64_t wall_ns = 0;
    std::optional<GapFacts> gap;
    std::uint64_t payload = 0;  ///< a hash of it
    friend bool operator==(const RecordFacts&, const RecordFacts&) = default;

    [[nodiscard]] std::uint64_t end() const { return samples_before + samples; }
};

/// "record 7 of epoch 2, samples 12..14"
[[nodiscard]] std::string text(const RecordFacts& facts);

/// A record, and its payload in the bytes.
struct ReadRecord {
    RecordFacts facts;
    Bytes payload;
};

/// The records in `bytes` that are whole and have a good checksum; other bytes are skipped.
[[nodiscard]] std::vector<ReadRecord> read_records(Bytes bytes);

struct CursorFacts {
    std::uint64_t counter = 0;
    std::uint64_t sequence = 0;
    std::uint64_t samples = 0;
    std::uint64_t delivered = 0;
    std::uint64_t dropped = 0;
};
/// @returns nothing: it is damaged
[[nodiscard]] std::optional<CursorFacts> read_cursor(Bytes bytes);

/// "restart", "quota", …
[[nodiscard]] std::string cause_name(std::uint16_t cause);
inline constexpr std::uint16_t kRestart = 1;
inline constexpr std::uint16_t kBufferFull = 2;
inline constexpr std::uint16_t kDiskFailed = 3;
inline constexpr std::uint16_t kDiskFull = 4;
inline constexpr std::uint16_t kSourceLost = 5;

}  // namespace takt::gatewaysim
