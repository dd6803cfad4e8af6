#include "journal/journal_segments.hpp"

#include <algorithm>
#include <span>

namespace takt::store {
namespace {

constexpr std::size_t kWindowBytes = std::size_t{256} * 1024;
static_assert(kWindowBytes >= 2 * kMaxRecordBytes);
// Of most segments, a start reads one record only.
constexpr std::size_t kFirstWindowBytes = std::size_t{64} * 1024;
static_assert(kFirstWindowBytes >= kMaxRecordBytes);

/// The start of a segment, of whose file only the first records are read.
Result<void> find_start(SegmentScanner& scanner, Segment& segment) {
    scanner.begin(segment.number);
    TAKT_TRY(const auto record, scanner.peek(segment.readable));
    if (!record) return {};
    segment.start = start_of(record->header);
    return {};
}

/// Reads a whole segment. @returns the end of its last record and the bytes after it
Result<void> find_end(SegmentScanner& scanner, const Segment& segment, RecoveredSegments& found) {
    scanner.begin(segment.number);
    std::uint64_t end = 0;  // of the last good record
    for (;;) {
        TAKT_TRY(const auto record, scanner.peek(segment.readable));
        if (!record) break;
        found.list.durable = end_of(record->header);
        scanner.consume(*record);
        end = scanner.offset();
    }
    found.torn_bytes = segment.readable - end;
    return {};
}

}  // namespace

void put_position(std::vector<std::uint8_t>& out, const StreamPosition& position) {
    put_little(out, position.sequence);
    put_little(out, position.samples);
    put_little(out, static_cast<std::uint64_t>(position.wall_ns));
    put_little(out, position.epoch);
}

StreamPosition take_position(LittleEndianReader& in) {
    StreamPosition position;
    position.sequence = in.take<std::uint64_t>();
    position.samples = in.take<std::uint64_t>();
    position.wall_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    position.epoch = in.take<std::uint64_t>();
    return position;
}

StreamPosition end_of(const RecordHeader& header) {
    return {header.sequence, header.samples_before + header.samples, header.wall_ns, header.epoch};
}

StreamPosition start_of(const RecordHeader& header) {
    return {header.sequence - 1, header.samples_before, header.wall_ns, header.epoch};
}

const Segment* SegmentList::holding(std::uint64_t sequence) const {
    for (auto segment = segments.rbegin(); segment != segments.rend(); ++segment)
        if (segment->start && segment->start->sequence < sequence) return &*segment;
    return nullptr;
}

const Segment* SegmentList::after(const Segment& segment) const {
    const auto found = std::ranges::find_if(segments, [&](const Segment& later) {
        return later.number > segment.number && later.start.has_value();
    });
    return found == segments.end() ? nullptr : &*found;
}

StreamPosition SegmentList::end_of_segment(const Segment& segment) const {
    const Segment* const next = after(segment);
    return next != nullptr ? *next->start : durable;
}

const Segment* SegmentList::first() const {
    const auto found =
        std::ranges::find_if(segments, [](const Segment& segment) { return segment.start.has_value(); });
    return found == segments.end() ? nullptr : &*found;
}

std::uint64_t SegmentList::total_bytes() const {
    std::uint64_t total = 0;
    for (const Segment& segment : segments) total += segment.bytes;
    return total;
}

void SegmentScanner::begin(std::uint64_t segment) {
    segment_ = segment;
    offset_ = 0;
    window_offset_ = 0;
    window_.clear();
}

Bytes SegmentScanner::window() const {
    const std::uint64_t skipped = offset_ - window_offset_;
    return skipped < window_.size() ? Bytes(window_).subspan(skipped) : Bytes{};
}

Result<void> SegmentScanner::fill(std::uint64_t readable) {
    const std::size_t most = offset_ == 0 ? kFirstWindowBytes : kWindowBytes;
    window_.resize(std::min<std::uint64_t>(readable - offset_, most));
    window_offset_ = offset_;
    const auto got = storage_->read(*segment_, offset_, window_);
    window_.resize(got ? *got : 0);
    TAKT_CHECK(got);
    return {};
}

Result<std::optional<DecodedRecord>> SegmentScanner::peek(std::uint64_t readable) {
    while (offset_ < readable) {
        DecodedRecord record = decode_record(window());
        const bool more = window_offset_ + window_.size() < readable;
        const bool fresh = window_offset_ == offset_ && !window_.empty();
        if (record.state == DecodeState::torn && more && (!fresh || window_.size() < kMaxRecordBytes)) {
            const std::size_t before = fresh ? window_.size() : 0;
            TAKT_CHECK(fill(readable));
            if (window_.empty()) return std::nullopt;  // the file is shorter than it was
            if (window_.size() > before) continue;
            record = decode_record(window());
        }
        if (record.state == DecodeState::good) return record;
        ++offset_;
    }
    return std::nullopt;
}

Result<RecoveredSegments> recover_segments(JournalStorage& storage) {
    TAKT_TRY(auto files, storage.list_segments());
    std::ranges::sort(files, {}, &SegmentFile::number);
    RecoveredSegments found;
    SegmentScanner scanner(storage);
    for (const SegmentFile& file : files) {
        Segment segment{.number = file.number, .bytes = file.bytes, .readable = file.bytes};
        TAKT_CHECK(find_start(scanner, segment));
        found.list.segments.push_back(segment);
        found.next_number = file.number + 1;
    }
    // A segment is followed by another one only after its last sync: the records of the last one may be the
    // only ones that are not durable.
    for (auto segment = found.list.segments.rbegin(); segment != found.list.segments.rend(); ++segment) {
        TAKT_CHECK(storage.sync(segment->number));
        if (!segment->start) continue;
        TAKT_CHECK(find_end(scanner, *segment, found));
        break;
    }
    return found;
}

}  // namespace takt::store
