// The reading half of the journal: what one destination has read and acknowledged.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "journal/journal_cursor.hpp"
#include "journal/journal_losses.hpp"
#include "journal/journal_reader.hpp"
#include "takt/store/journal.hpp"

namespace takt::store {

class JournalDestination {
public:
    /// All but `name` must outlive the destination.
    JournalDestination(const SegmentList& segments, JournalStorage& storage, KnownLosses& losses,
                       std::string name)
        : segments_(&segments),
          storage_(&storage),
          losses_(&losses),
          cursor_(storage, std::move(name)),
          reader_(segments, storage, {}) {}

    /// Loads the cursor, to be called first. @returns the errors of the storage
    Result<void> load();
    /// To be called after load(). A cursor that is missing or damaged begins with the oldest record.
    /// @param end  of the stream
    Result<void> start(const StreamPosition& end);

    [[nodiscard]] Result<std::optional<JournalEntry>> read(std::size_t max_in_flight);
    /// @returns out_of_range
    Result<void> acknowledge(std::uint64_t sequence);
    /// @returns out_of_range
    Result<void> reject(std::uint64_t sequence, std::uint64_t samples, std::uint64_t gaps);
    void rewind();
    /// No entry was handed out that read() did not return; to be called before a save at the end of reading.
    void withdraw_announcement();
    /// Moves the cursor to a position before it.
    void go_back(const StreamPosition& position);

    [[nodiscard]] bool has_unsaved() const { return !(state_ == cursor_.durable()) || needs_quota_end(); }
    /// Whether a later run would need SegmentList::quota_end and does not have it.
    [[nodiscard]] bool needs_quota_end() const;
    Result<void> save();

    [[nodiscard]] const std::string& name() const { return cursor_.name(); }
    [[nodiscard]] const CursorState& state() const { return state_; }
    [[nodiscard]] std::uint64_t durable_sequence() const { return cursor_.durable().position.sequence; }
    /// See Journal. Reads the storage once for each position of the cursor.
    [[nodiscard]] std::optional<std::int64_t> oldest_waiting_ns();
    /// @param samples  of the stream, to its end
    /// @param open     of them, lost ones at the end that are not among the known losses
    [[nodiscard]] DestinationCounters counters(std::uint64_t samples, std::uint64_t open) const;

private:
    /// The oldest waiting sample that was read from the storage for this position of the cursor.
    struct FoundOldest {
        std::uint64_t cursor = 0;         // sequence number
        std::uint64_t first_segment = 0;  // another one: the quota may have dropped the sample
        std::int64_t wall_ns = 0;
    };

    void announce_reads();
    [[nodiscard]] std::optional<std::int64_t> find_oldest() const;

    const SegmentList* segments_;
    JournalStorage* storage_;
    KnownLosses* losses_;
    JournalCursor cursor_;
    JournalCursor::Found found_ = JournalCursor::Found::nothing;
    CursorState state_;
    JournalReader reader_;
    std::deque<CursorState> in_flight_;  // the state after the acknowledgement of each entry that was read
    std::optional<FoundOldest> oldest_;
    std::uint64_t highest_read_ = 0;  // sequence number, in this run or perhaps an earlier one
};

}  // namespace takt::store
