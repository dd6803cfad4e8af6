// The chunks of a history file and their roll-ups. All functions throw SQLite::Exception.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "database.hpp"
#include "history_summary.hpp"
#include "history_tables.hpp"

namespace takt::store {

/// A chunk's row in the table of roll-ups.
struct ChunkRow {
    std::int64_t id = 0;
    SeriesId series;
    bool open = false;  ///< it is replaced by a later one
    HistorySummary summary;
};

inline constexpr std::int64_t kHour = 3'600'000'000'000;

/// Prepared once: the row and the bytes of chunks.
class ChunkWriter {
public:
    explicit ChunkWriter(SQLite::Database& database);
    void write(const ChunkRow& row, const std::vector<std::uint8_t>& data);
    void erase(SeriesId series, std::int64_t begin_ns, std::int64_t id);
    /// Replaces only the row of a chunk. @param begin_ns  of the row that is replaced
    void rewrite(std::int64_t begin_ns, const ChunkRow& row);
    /// Brings the digests of the variables up to date. Required after the last of the other calls.
    void finish(HistoryState& state);

private:
    void write_row(const ChunkRow& row);
    void erase_row(SeriesId series, std::int64_t begin_ns, std::int64_t id);

    SQLite::Database& database_;
    SQLite::Statement row_;
    SQLite::Statement data_;
    SQLite::Statement erase_row_;
    SQLite::Statement erase_data_;
    std::map<SeriesId, RowsDigest> changes_;
};

/// The chunks of a variable.
struct SeriesChunks {
    struct Restored {
        std::int64_t begin_ns = 0;  ///< of the damaged row
        ChunkRow row;
    };
    std::vector<ChunkRow> rows;         ///< by their begin; of equal ones by their numbers
    std::vector<Restored> restored;     ///< rows that were recomputed from their chunks; they are in `rows`
    std::vector<HistoryDamage> damage;  ///< chunks that are missing in `rows`
};

/// Checks the rows of a variable. A damaged one is recomputed from its chunk, if this is surely the chunk of
/// the row.
/// @param gaps  all, by their first times
[[nodiscard]] SeriesChunks read_chunks(SQLite::Database& database, const SeriesRow& series,
                                       const HistoryGaps& gaps);
/// The greatest number of a chunk; 0: there is none.
[[nodiscard]] std::int64_t last_chunk(SQLite::Database& database);

/// The samples of a chunk, in order of time.
/// @returns malformed: they are damaged, or not those of the row
[[nodiscard]] Result<std::vector<HistorySample>> read_samples(SQLite::Database& database,
                                                              const ChunkRow& row);
/// The damage of a chunk.
[[nodiscard]] HistoryDamage damage_of(const ChunkRow& row, const std::string& variable);

/// Deletes up to `most` closed chunks, the oldest first, that end before `cutoff_ns`. @returns how many
[[nodiscard]] std::size_t drop_chunks(SQLite::Database& database, HistoryState& state, std::int64_t cutoff_ns,
                                      std::size_t most);

/// A repair may not rely on indexes: they may not fit their damaged table.
void drop_rollup_indexes(SQLite::Database& database);
void make_rollup_indexes(SQLite::Database& database);

/// Gives all rows of gaps, variables and roll-ups sums, as they are.
void add_sums(SQLite::Database& database);
/// Sets all digests to what the tables have, except the digest of the log, which becomes that of an empty log
/// if the log is empty.
void count_rows(SQLite::Database& database, HistoryState& state);

}  // namespace takt::store
