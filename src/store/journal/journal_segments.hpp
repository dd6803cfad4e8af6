// The segment files of a journal: what each one holds, and the search for records in one of them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "journal/little_endian.hpp"
#include "takt/store/journal_record.hpp"
#include "takt/store/journal_storage.hpp"

namespace takt::store {

/// The end of a record in the stream.
struct StreamPosition {
    std::uint64_t sequence = 0;  ///< of the record; 0: the beginning of the stream
    std::uint64_t samples = 0;   ///< samples, written and missing, up to the end of the record
    std::int64_t wall_ns = 0;    ///< of the record
    std::uint64_t epoch = 0;     ///< of the record

    friend bool operator==(const StreamPosition&, const StreamPosition&) = default;
};

/// 32 bytes, little endian.
void put_position(std::vector<std::uint8_t>& out, const StreamPosition& position);
[[nodiscard]] StreamPosition take_position(LittleEndianReader& in);

[[nodiscard]] StreamPosition end_of(const RecordHeader& header);
/// The position before a record. Time and epoch are those of the record itself.
[[nodiscard]] StreamPosition start_of(const RecordHeader& header);

struct Segment {
    std::uint64_t number = 0;
    std::uint64_t bytes = 0;              ///< size of the file
    std::uint64_t readable = 0;           ///< durable bytes
    std::uint64_t limit = 0;              ///< of its size, while it takes records
    std::optional<StreamPosition> start;  ///< before its first good durable record; none: it has no record
};

/// The segments in the order of their numbers. The invariant: the records of a segment from the first record
/// of the next one on are ignored. They were not durable, and were written to the next segment again.
struct SegmentList {
    std::vector<Segment> segments;
    StreamPosition durable;    ///< end of the last durable record
    StreamPosition quota_end;  ///< end of the newest records that the quota has removed

    /// The segment in which the record is, if it was not damaged. Null: the first segment begins after it.
    [[nodiscard]] const Segment* holding(std::uint64_t sequence) const;
    /// The next segment with a record; null: there is none.
    [[nodiscard]] const Segment* after(const Segment& segment) const;
    /// The end of the records of a segment.
    [[nodiscard]] StreamPosition end_of_segment(const Segment& segment) const;
    /// The first segment with a record; null: there is no record.
    [[nodiscard]] const Segment* first() const;
    [[nodiscard]] std::uint64_t total_bytes() const;
};

/// Finds the good records of a segment in their order. Bytes that are no record are skipped.
class SegmentScanner {
public:
    explicit SegmentScanner(JournalStorage& storage) : storage_(&storage) {}

    /// Goes to the beginning of a segment.
    void begin(std::uint64_t segment);
    /// The segment of the last begin(); none before it.
    [[nodiscard]] std::optional<std::uint64_t> segment() const { return segment_; }

    /// The next good record within the first `readable` bytes; none: there are no more. The payload is valid
    /// until the next peek() or begin(). @returns the errors of the storage
    [[nodiscard]] Result<std::optional<DecodedRecord>> peek(std::uint64_t readable);
    /// Goes behind a record of peek().
    void consume(const DecodedRecord& record) { offset_ += record.bytes; }
    /// Where the next record may begin: behind the last consumed one.
    [[nodiscard]] std::uint64_t offset() const { return offset_; }

private:
    [[nodiscard]] Result<void> fill(std::uint64_t readable);
    [[nodiscard]] Bytes window() const;

    JournalStorage* storage_;
    std::optional<std::uint64_t> segment_;
    std::uint64_t offset_ = 0;         // of the next record
    std::uint64_t window_offset_ = 0;  // of window_ in the file
    std::vector<std::uint8_t> window_;
};

struct RecoveredSegments {
    SegmentList list;
    std::uint64_t torn_bytes = 0;  ///< bytes after the last good record
    std::uint64_t next_number = 1;
};

/// Finds the records that an earlier run left, and makes the last ones durable: the earlier run may have
/// ended between a write and its sync. Reads one record of each segment, and all of the last one.
/// @returns the errors of the storage
[[nodiscard]] Result<RecoveredSegments> recover_segments(JournalStorage& storage);

}  // namespace takt::store
