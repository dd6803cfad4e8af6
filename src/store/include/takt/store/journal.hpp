// The journal: samples on the disk until every destination has acknowledged them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/store/journal_storage.hpp"
#include "takt/store/journal_stream.hpp"

namespace takt::store {

struct JournalOptions {
    std::size_t segment_bytes = 16U << 20;       ///< 64 KiB to 1 GiB
    std::size_t buffer_bytes = 8U << 20;         ///< records that are not durable; 128 KiB to 256 MiB
    std::uint64_t quota_bytes = 4ULL << 30;      ///< all segments; at least two segments
    Duration sync_interval{100'000'000};         ///< > 0: from the first waiting record to its sync
    Duration cursor_interval{1'000'000'000};     ///< > 0: from an acknowledgement to the sync of its cursor
    Duration retention{7 * 86'400'000'000'000};  ///< time for which acknowledged records stay
    std::size_t max_in_flight = 4096;            ///< records read and not acknowledged, of a destination; > 0
    /// Of the gap that each start writes: restart, or replaced if this program had the journal open before.
    GapCause start = GapCause::restart;
};

/// A number of samples that are written and acknowledged together.
struct JournalInput {
    std::uint64_t samples = 1;                   ///< in the payload
    std::int64_t wall_ns = 0;                    ///< see RecordHeader
    std::int64_t monotonic_ns = 0;               ///< see RecordHeader
    Bytes payload;                               ///< copied; at most kMaxPayloadBytes
    std::optional<std::int64_t> oldest_wall_ns;  ///< of the oldest sample; nothing: there is one time only
};

/// Samples that were lost before they reached the journal.
struct JournalLoss {
    std::uint64_t samples = 0;
    std::int64_t first_wall_ns = 0;
    std::int64_t last_wall_ns = 0;
    /// A buffer in front of the journal was full, so that the cause is that of a full buffer of the journal;
    /// else the source lost them.
    bool buffer_full = false;
};

/// Samples of a destination. appended = delivered + waiting + dropped at all times. The counts are kept in
/// the cursor: they continue after a restart with the last durable state.
///
/// A missing sample is dropped as soon as it is known to be missing. After a start the journal reads what
/// waits, in steps of 256 KB from open() on: until it has read it, gaps and damage of earlier runs count as
/// waiting. Damage that comes later is known when it is read.
struct DestinationCounters {
    std::uint64_t appended = 0;   ///< since the destination was created, missing samples included
    std::uint64_t delivered = 0;  ///< acknowledged as records
    std::uint64_t waiting = 0;    ///< neither delivered nor known to be missing
    std::uint64_t dropped = 0;    ///< in gaps, acknowledged or not, or rejected
    std::uint64_t gaps = 0;       ///< with samples, acknowledged or not; after a go_back() they count again
};

struct JournalStatus {
    std::optional<Error> failure;        ///< of the disk; none as soon as a sync succeeded again
    std::uint64_t samples = 0;           ///< written and missing, since the journal was created
    std::uint64_t last_sequence = 0;     ///< of the last record that was accepted
    std::uint64_t durable_sequence = 0;  ///< of the last record that can be read
    /// Of this run: one more than that of the run before. The first one of a journal is the second of its
    /// creation since 1970.
    std::uint64_t epoch = 0;
    std::uint64_t disk_bytes = 0;      ///< size of all segments
    std::size_t segments = 0;          ///< files
    std::size_t buffer_bytes = 0;      ///< records that are not durable
    std::uint64_t buffer_samples = 0;  ///< samples that are not durable, missing ones included
    std::uint64_t torn_bytes = 0;      ///< cut at the start: bytes after the last good record
    std::string set_aside;             ///< see JournalStorage
    // Counters of this run.
    std::uint64_t samples_lost = 0;    ///< they did not fit the buffer, or the source lost them
    std::uint64_t syncs = 0;           ///< successful, of segments
    std::uint64_t write_failures = 0;  ///< of create, append and sync
    std::uint64_t cursor_failures = 0;
    std::uint64_t remove_failures = 0;
    std::uint64_t dropped_segments = 0;  ///< removed by the quota before all destinations acknowledged them
};

/// A destination of one Journal: its index in the list given to Journal::open().
struct DestinationId {
    std::size_t index = 0;
    friend bool operator==(DestinationId, DestinationId) = default;
};

/// An append-only journal in segment files, with a cursor for each destination.
///
/// append() copies a record into a memory buffer. on_tick() writes the buffer to the disk with one sync for
/// each sync_interval; read() returns a record only after its sync. What the buffer cannot hold is counted
/// and becomes a gap in its place. After an error of the disk the journal begins another segment, and writes
/// there again what was not durable; it tries again after 100 ms to 5 s, and append() continues meanwhile.
///
/// A segment is removed as soon as every destination has durably acknowledged its records and the retention
/// is over. Above the quota the oldest segment is removed in any case: each destination that did not
/// acknowledge it reads a gap. Each start writes a gap (JournalOptions::start).
///
/// The end of the stream is noted after each sync, and each second while the disk fails. So a start knows
/// records that another program removed behind the last good one, and samples that a failing disk did not
/// take: each is an exact gap.
///
/// Time is given by the caller and must not run backwards. One owner, one thread. Only on_tick(), close(),
/// next(), read() and oldest_waiting_ns() access the storage; they may block for as long as it does.
class Journal {
public:
    /// Reads what an earlier run left, and adds the destinations: DestinationId{i} is the one with
    /// destinations[i]. A known one continues after its last durable acknowledgement. If its cursor is
    /// missing or neither slot is good, it begins with the oldest record: the destination then gets records
    /// again, marked as repeated, and misses none of those that are there. What the quota removed before is
    /// not reported then. A destination that is new in an existing journal does the same.
    ///
    /// @param storage       must outlive the journal
    /// @param destinations  1 to 64 of a-z, 0-9, `-`, `_` each; used as the name of a file
    /// @param wall_ns       wall-clock time of the start
    /// @returns out_of_range (an option), malformed (a name), busy (a name is there twice), the errors of the
    ///          storage: nothing is lost, try again later
    [[nodiscard]] static Result<Journal> open(JournalStorage& storage, const JournalOptions& options,
                                              std::span<const std::string_view> destinations, Instant now,
                                              std::int64_t wall_ns);

    Journal(Journal&&) noexcept;
    Journal& operator=(Journal&&) noexcept;
    /// Does not write: records in the buffer are lost, see close().
    ~Journal();

    /// @returns too_long: nothing was done; queue_full: the samples are counted, and a gap replaces them
    Result<void> append(Instant now, const JournalInput& input);
    /// Writes a gap.
    void append_loss(Instant now, const JournalLoss& loss);

    /// When on_tick() is to be called; kNever: there is nothing to do.
    [[nodiscard]] Instant next_wakeup() const;
    void on_tick(Instant now, std::int64_t wall_ns);
    /// Writes the buffer, the cursors and the end of the stream without delay. @returns the error of the
    /// storage; the records stay in the buffer. If this run ends now, the next one has a gap for them
    Result<void> close(Instant now);

    /// The next durable record for a destination, in order. The cursor does not move.
    /// @returns none: everything durable was read, or max_in_flight entries are not acknowledged; io_failed
    [[nodiscard]] Result<std::optional<JournalEntry>> read(DestinationId destination);
    /// Moves the cursor: all entries up to `sequence` are delivered.
    /// @returns out_of_range: no entry with this number was read and not acknowledged. Nothing was changed
    Result<void> acknowledge(Instant now, DestinationId destination, std::uint64_t sequence);
    /// Counts samples of an entry as dropped that the destination can never take; to be called before its
    /// acknowledgement. A rewind() forgets it.
    /// @param gaps  that the destination gets in their place
    /// @returns out_of_range: as acknowledge(), or the entry has fewer samples
    Result<void> reject(DestinationId destination, std::uint64_t sequence, std::uint64_t samples,
                        std::uint64_t gaps = 0);
    /// The next read() begins after the last acknowledged entry. Entries that were read before are
    /// `repeated`.
    void rewind(DestinationId destination);
    /// The last sequence number that the destination has acknowledged.
    [[nodiscard]] std::uint64_t acknowledged(DestinationId destination) const;
    /// The last sequence number that the destination has acknowledged durably.
    [[nodiscard]] std::uint64_t durable_cursor(DestinationId destination) const;
    [[nodiscard]] DestinationCounters counters(DestinationId destination) const;
    /// Wall time of the oldest durable record of samples that the destination has not acknowledged; none:
    /// there is no such record, or the storage cannot be read. A gap is no such record.
    [[nodiscard]] std::optional<std::int64_t> oldest_waiting_ns(DestinationId destination);

    /// Makes a destination read again from `sequence` on, or from the oldest record if that is gone. Its
    /// counters go back too. Durable after close(), or with the next sync of the cursor.
    /// @returns the samples that wait now and did not before; 0: the destination is not past `sequence`,
    ///          nothing was changed. The errors of the storage
    Result<std::uint64_t> go_back(Instant now, DestinationId destination, std::uint64_t sequence);
    /// Reads from `sequence` on, or from the oldest record if that is gone. Independent of all cursors; the
    /// journal must outlive the stream.
    [[nodiscard]] std::unique_ptr<JournalStream> replay(std::uint64_t sequence) const;
    /// A sequence number before which all records are older than `wall_ns`, exact to a segment.
    [[nodiscard]] std::uint64_t sequence_before(std::int64_t wall_ns) const;

    [[nodiscard]] JournalStatus status() const;

private:
    struct State;
    explicit Journal(std::unique_ptr<State> state);

    std::unique_ptr<State> state_;
};

}  // namespace takt::store
