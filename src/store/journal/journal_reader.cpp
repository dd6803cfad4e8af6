#include "journal/journal_reader.hpp"

#include <algorithm>

namespace takt::store {

Result<std::optional<JournalEntry>> JournalReader::next() {
    while (at_.sequence < segments_->durable.sequence) {
        const std::uint64_t expected = at_.sequence + 1;
        const Segment* segment = segments_->holding(expected);
        if (segment == nullptr) {
            const Segment* first = segments_->first();
            return gap_until(first != nullptr ? *first->start : segments_->durable);
        }
        if (scanner_.segment() != segment->number) scanner_.begin(segment->number);
        const StreamPosition end = segments_->end_of_segment(*segment);
        TAKT_TRY(const auto record, scanner_.peek(segment->readable));
        if (!record || record->header.sequence > end.sequence) return gap_until(end);
        if (record->header.sequence > expected) return gap_until(start_of(record->header));
        scanner_.consume(*record);
        if (record->header.sequence == expected) return deliver(*record);
    }
    return std::nullopt;
}

/// Records are missing up to `end`: those that the quota has removed, then others. A segment of which a write
/// failed may have been kept, although the next one, which has its records again, was removed.
JournalEntry JournalReader::gap_until(const StreamPosition& end) {
    const StreamPosition& quota = segments_->quota_end;
    if (quota.sequence <= at_.sequence) return gap_until(end, GapCause::damaged);
    return gap_until(quota.sequence < end.sequence ? quota : end, GapCause::quota);
}

// The record after may be older than the one before: its samples were taken before the start that a gap
// `restart` stands for, or the clock was set back.
JournalEntry JournalReader::gap_until(const StreamPosition& end, GapCause cause) {
    JournalEntry entry;
    entry.gap = Gap{.cause = cause,
                    .samples = end.samples - at_.samples,
                    .first_sequence = at_.sequence + 1,
                    .last_sequence = end.sequence,
                    .first_wall_ns = std::min(at_.wall_ns, end.wall_ns),
                    .last_wall_ns = end.wall_ns};
    entry.header = {RecordType::gap, entry.gap->samples, end.sequence, at_.samples, end.wall_ns, 0,
                    end.epoch};
    at_ = end;
    // The record at `end` is not read yet: it does not bound the age of a gap that follows.
    at_.wall_ns = entry.gap->first_wall_ns;
    return entry;
}

JournalEntry JournalReader::deliver(const DecodedRecord& record) {
    JournalEntry entry;
    entry.header = record.header;
    at_ = end_of(record.header);
    if (record.header.type == RecordType::samples) {
        entry.payload = record.payload;
        return entry;
    }
    const auto gap = decode_gap(record.payload);
    entry.gap = gap ? *gap : Gap{.cause = GapCause::damaged, .samples = record.header.samples};
    entry.gap->first_sequence = entry.gap->last_sequence = record.header.sequence;
    return entry;
}

namespace {

/// Before the first record of the segment that holds `sequence`, else of the oldest one.
StreamPosition start_for(const SegmentList& segments, std::uint64_t sequence) {
    const Segment* segment = segments.holding(sequence);
    if (segment == nullptr) segment = segments.first();
    return segment != nullptr ? *segment->start : segments.durable;
}

}  // namespace

JournalReplay::JournalReplay(const SegmentList& segments, JournalStorage& storage, std::uint64_t sequence)
    : reader_(segments, storage, start_for(segments, sequence)), sequence_(sequence) {}

Result<std::optional<JournalEntry>> JournalReplay::next() {
    for (;;) {
        TAKT_TRY(auto entry, reader_.next());
        if (!entry || entry->header.sequence >= sequence_) return entry;
    }
}

}  // namespace takt::store
