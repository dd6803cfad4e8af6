// The records of the journal, as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"

namespace takt::store {

/// The numbers are stored and stable.
enum class RecordType : std::uint16_t {
    samples = 1,  ///< the payload belongs to the writer; the journal does not read it
    gap = 2,      ///< samples that are missing in this place; the payload is an encoded Gap
};

/// Why samples are missing. The numbers are stored and stable.
enum class GapCause : std::uint16_t {
    restart = 1,  ///< the program was not running, or stopped before these samples were durable
    buffer_full,  ///< more samples than the memory buffer can hold
    disk_failed,  ///< the buffer was full because the disk reported an error
    disk_full,    ///< the buffer was full because the disk was full
    source_lost,  ///< the source lost events before they reached the journal
    quota,        ///< the oldest segment was removed before it was delivered
    damaged,      ///< the bytes on the disk are not the ones that were written, or the file is gone
    replaced,     ///< a changed project took the place of the running one
};

/// The stable name of a cause, as in "buffer_full".
std::string_view name(GapCause cause);

/// All of a record but its payload.
struct RecordHeader {
    RecordType type = RecordType::samples;
    std::uint64_t samples = 0;         ///< samples in the payload; of a gap: Gap::samples
    std::uint64_t sequence = 0;        ///< from 1 on, one for each record, never reused
    std::uint64_t samples_before = 0;  ///< samples (written and missing) of all records before this one
    std::int64_t wall_ns = 0;          ///< wall-clock time of the newest sample, ns since 1970 UTC
    std::int64_t monotonic_ns = 0;     ///< monotonic time of the newest sample; comparable within an epoch
    std::uint64_t epoch = 0;           ///< start of the program that wrote the record; never reused

    friend bool operator==(const RecordHeader&, const RecordHeader&) = default;
};

/// Missing samples. A gap is in the stream in the place of the samples.
struct Gap {
    GapCause cause{};
    std::uint64_t samples = 0;         ///< exact. Zero for a start: the number is not known
    std::uint64_t first_sequence = 0;  ///< the gap replaces these records; a gap that was written as a record
    std::uint64_t last_sequence = 0;   ///< replaces only itself
    /// For a gap that was written: of the oldest missing sample. For quota and damaged: of the record before
    /// the gap, or of the one after it if that is older. Not after `last_wall_ns`, except of a start.
    std::int64_t first_wall_ns = 0;
    std::int64_t last_wall_ns = 0;  ///< of the newest missing sample; quota and damaged: of the record after

    friend bool operator==(const Gap&, const Gap&) = default;
};

inline constexpr std::size_t kRecordHeaderBytes = 60;
inline constexpr std::size_t kRecordOverheadBytes = kRecordHeaderBytes + 4;  ///< header and checksum
inline constexpr std::size_t kMaxPayloadBytes = 60'000;
inline constexpr std::size_t kMaxRecordBytes = kMaxPayloadBytes + kRecordOverheadBytes;
inline constexpr std::size_t kGapPayloadBytes = 48;
inline constexpr std::size_t kGapRecordBytes = kGapPayloadBytes + kRecordOverheadBytes;

/// Appends the bytes of a record to `out`. `payload` has at most kMaxPayloadBytes.
void encode_record(const RecordHeader& header, Bytes payload, std::vector<std::uint8_t>& out);

enum class DecodeState : std::uint8_t {
    good,
    torn,     ///< the bytes end before the record does
    damaged,  ///< these bytes are not the beginning of a record
};

struct DecodedRecord {
    DecodeState state = DecodeState::damaged;
    RecordHeader header;    ///< if good
    Bytes payload;          ///< if good: a part of the decoded bytes
    std::size_t bytes = 0;  ///< if good: the size of the record
};

/// Decodes the record at the beginning of `bytes`. Bytes after the record are not read.
[[nodiscard]] DecodedRecord decode_record(Bytes bytes);

/// Whether `bytes` may be the beginning of a record: a cheap test before decode_record().
[[nodiscard]] bool begins_record(Bytes bytes);

/// The header and size of a record that this process encoded, without a check.
[[nodiscard]] RecordHeader encoded_header(Bytes record);
[[nodiscard]] std::size_t encoded_size(Bytes record);

void encode_gap(const Gap& gap, std::vector<std::uint8_t>& out);
/// @returns malformed
[[nodiscard]] Result<Gap> decode_gap(Bytes payload);

}  // namespace takt::store
