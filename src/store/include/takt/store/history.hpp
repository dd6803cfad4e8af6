// The history: every sample of the last days in an SQLite file, one to two bytes each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/store/history_damage.hpp"
#include "takt/store/history_sample.hpp"

namespace takt::store {

struct HistoryOptions {
    Duration retention{30LL * 86'400'000'000'000};  ///< older chunks are dropped; zero: never
    std::uint64_t quota_bytes = 4ULL << 30;         ///< pages in use; 0: no limit
    std::size_t chunk_samples = 1000;               ///< the most in a chunk; > 0
    std::size_t log_bytes = 2U << 20;               ///< committed samples that are in no chunk
    std::size_t log_commits = 600;                  ///< of the same; > 0
    Duration drop_time{20'000'000};                 ///< the most that one commit spends on dropping
};

struct HistoryStatus {
    std::uint64_t samples = 0;     ///< committed by this run
    std::uint64_t repeated = 0;    ///< appended again after a restart, and skipped
    std::uint64_t chunks = 0;      ///< written by this run, rewritten ones not counted
    std::uint64_t dropped = 0;     ///< chunks dropped by this run
    std::uint64_t used_bytes = 0;  ///< pages in use
    std::uint64_t file_bytes = 0;  ///< the main file; it never shrinks
    std::size_t pending = 0;       ///< samples that are not committed
    /// Of folding or dropping, after a successful commit: nothing is lost, the next commit tries again.
    std::optional<Error> failure;
    std::string set_aside;  ///< where commit() moved the damaged file; empty: it did not
};

/// Writes a history. One owner, one thread. commit() blocks for as long as the disk does.
///
/// Readers of the same file (HistoryReader) see what is committed, at any time and in any process.
class History {
public:
    struct Opened;

    /// Opens or creates the file. One that SQLite cannot read is moved aside, with its log, to the first free
    /// of "PATH.damaged-1" to "-999", and a new one begun, with a gap `damaged` in the place of the samples.
    /// Damaged rows of the log and damaged open chunks are replaced by gaps; other chunks are not read here
    /// (HistoryReader::damage()).
    /// @returns busy (another program writes it); unsupported (not a history, or of a newer version: it is
    ///          left alone); cannot_open, io_failed
    [[nodiscard]] static Result<Opened> open(const std::string& path, const HistoryOptions& options = {});

    ~History();
    History(const History&) = delete;
    History& operator=(const History&) = delete;

    /// The series of that name; it is added, or gets the other properties. Committed at once.
    /// @returns the errors of commit()
    [[nodiscard]] Result<SeriesId> series(const HistorySeries& properties);

    /// The record that the samples and gaps appended next belong to. The samples and gaps of a record that is
    /// committed already (same journal, no greater sequence) are skipped. Where nothing is ever skipped,
    /// this need not be called.
    void begin_record(const HistoryPosition& position);
    /// Times may run backwards. `series` comes from series().
    void append(SeriesId series, const HistorySample& sample);
    void append(const HistoryGap& gap);

    /// Makes everything appended durable, with the position, in one transaction. After success the caller may
    /// acknowledge its journal. Also moves committed samples into chunks and drops old chunks, within bounds.
    /// @param wall_ns  now, for the retention
    /// @returns io_failed (ENOSPC: the disk is full), busy, replaced: nothing was committed; call again
    ///          later. malformed: the file is damaged and was moved aside (HistoryStatus::set_aside), as by
    ///          open(). Open the history again, and read the journal again from its last acknowledged record
    Result<void> commit(std::int64_t wall_ns);

    /// Of the last committed record; nothing in a new file.
    [[nodiscard]] std::optional<HistoryPosition> position() const;
    [[nodiscard]] HistoryStatus status() const;

private:
    struct State;
    explicit History(std::unique_ptr<State> state);

    std::unique_ptr<State> state_;
};

struct History::Opened {
    std::unique_ptr<History> history;
    std::string set_aside;  ///< where a damaged file was moved; empty: there was none
    /// Of rows of the file that was opened. A gap `damaged` is in the place of their samples.
    std::vector<HistoryDamage> damage;
};

}  // namespace takt::store
