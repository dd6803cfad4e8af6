// Reads the stream from the segments and finds what is missing.
#pragma once

#include "journal/journal_segments.hpp"
#include "takt/store/journal_stream.hpp"

namespace takt::store {

/// Segments may be added and removed between two calls. `segments` and `storage` must outlive the reader.
class JournalReader final : public JournalStream {
public:
    /// Begins with the record after `start`.
    JournalReader(const SegmentList& segments, JournalStorage& storage, const StreamPosition& start)
        : segments_(&segments), scanner_(storage), at_(start) {}

    [[nodiscard]] Result<std::optional<JournalEntry>> next() override;
    [[nodiscard]] const StreamPosition& position() const { return at_; }

private:
    [[nodiscard]] JournalEntry gap_until(const StreamPosition& end);
    [[nodiscard]] JournalEntry gap_until(const StreamPosition& end, GapCause cause);
    [[nodiscard]] JournalEntry deliver(const DecodedRecord& record);

    const SegmentList* segments_;
    SegmentScanner scanner_;
    StreamPosition at_;  // end of the last entry
};

/// Reads from a record on, or from the oldest one if that is gone.
class JournalReplay final : public JournalStream {
public:
    JournalReplay(const SegmentList& segments, JournalStorage& storage, std::uint64_t sequence);

    [[nodiscard]] Result<std::optional<JournalEntry>> next() override;

private:
    JournalReader reader_;
    std::uint64_t sequence_;  // the first to be read
};

}  // namespace takt::store
