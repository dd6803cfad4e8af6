// The writing half of the journal: the memory buffer, the active segment, gaps for what the buffer lost.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "journal/journal_end.hpp"
#include "journal/journal_losses.hpp"
#include "journal/journal_segments.hpp"
#include "takt/store/journal.hpp"

namespace takt::store {

/// Owner of the segments. Records are encoded when they are accepted; a sequence number leaves the program
/// only after its record is durable, so that a number lost with the buffer was never seen.
class JournalWriter {
public:
    /// `storage` and `losses` must outlive the writer. It adds its gaps and what the quota removes to
    /// `losses`.
    JournalWriter(JournalStorage& storage, const JournalOptions& options, KnownLosses& losses,
                  RecoveredSegments recovered);

    /// What an earlier run noted, to be called before begin_epoch().
    void set_quota_end(const StreamPosition& end) { list_.quota_end = end; }
    /// `save` is called when SegmentList::quota_end has moved, before the records up to it are removed.
    void on_quota_end(std::function<void()> save) { save_quota_end_ = std::move(save); }

    /// Accepts the first records of this run: a gap of what the run before had in memory only, and the gap
    /// between the last durable record and now.
    /// @param last  the last record that was durable: of the segments, or the highest of all notes of it
    /// @param end   what the run before noted
    void begin_epoch(Instant now, std::int64_t wall_ns, const StreamPosition& last,
                     const std::optional<JournalEnd>& end);
    /// For the next run.
    [[nodiscard]] JournalEnd end() const;

    Result<void> append(Instant now, const JournalInput& input);
    void append_loss(Instant now, const Gap& gap);
    /// Why a full buffer is full.
    [[nodiscard]] GapCause cause_of_loss() const;

    [[nodiscard]] Instant next_wakeup() const { return due_; }
    /// Writes the buffer and syncs it. After an error the segment is abandoned.
    Result<void> flush(Instant now);

    /// Removes the segments without records, and those that end at or before `acknowledged` and are followed
    /// by a segment that began before `wall_ns`.
    void clean(std::uint64_t acknowledged, std::int64_t wall_ns);

    [[nodiscard]] const SegmentList& segments() const { return list_; }
    /// End of the last accepted record; samples of an open gap are included.
    [[nodiscard]] std::uint64_t samples() const { return end_.samples + open_samples(); }
    /// Samples of an open gap.
    [[nodiscard]] std::uint64_t open_samples() const { return open_gap_ ? open_gap_->samples : 0; }
    /// All but the counters of the cursors.
    [[nodiscard]] JournalStatus status() const;
    [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }
    /// The last sequence number that every destination has acknowledged, for the count of dropped segments.
    void set_acknowledged(std::uint64_t sequence) { acknowledged_ = sequence; }

private:
    void push(const RecordHeader& header, Bytes payload);
    void push_gap(const Gap& gap);
    void close_gap();
    void schedule(Instant now);
    [[nodiscard]] bool has_room(std::size_t bytes) const {
        return pending_.size() + bytes <= options_.buffer_bytes;
    }
    Result<void> write_pending();
    Result<void> write_slice();
    Result<void> open_segment();
    Result<void> sync();
    Result<void> limit_empty_segments();
    void make_room_on_disk();
    void announce_drop(const StreamPosition& end);
    [[nodiscard]] bool remove(std::size_t index);
    void abandon(Instant now, const Error& error);
    [[nodiscard]] Segment& active() { return list_.segments.back(); }

    JournalStorage* storage_;
    KnownLosses* losses_;
    JournalOptions options_;
    SegmentList list_;
    std::uint64_t next_number_;
    std::uint64_t torn_bytes_;
    StreamPosition end_;  // of the last accepted record
    std::uint64_t epoch_ = 0;
    std::uint64_t acknowledged_ = 0;
    std::function<void()> save_quota_end_;

    std::vector<std::uint8_t> pending_;          // records that are not durable
    std::size_t written_ = 0;                    // bytes of pending_ in the active segment, not synced
    std::optional<RecordHeader> written_first_;  // of those
    std::optional<RecordHeader> written_last_;
    bool has_active_ = false;      // the last segment of the list takes records
    std::optional<Gap> open_gap_;  // lost samples that are not in pending_ yet

    Instant due_ = kNever;
    Duration back_off_{};
    std::optional<Error> failure_;
    JournalStatus counts_;
};

}  // namespace takt::store
