// The chunks of a history file and their roll-ups. All functions throw SQLite::Exception.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <vector>

#include "history/history_summary.hpp"
#include "history/history_tables.hpp"
#include "registers/database.hpp"

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
    /// Brings the digests of the variables up to date. Required after the last of the other calls.
    void finish(HistoryState& state);

private:
    SQLite::Database& database_;
    SQLite::Statement row_;
    SQLite::Statement data_;
    SQLite::Statement erase_row_;
    SQLite::Statement erase_data_;
    std::map<SeriesId, RowsDigest> changes_;
};

/// The chunks of a variable.
struct SeriesChunks {
    std::vector<ChunkRow> rows;         ///< by their begin; of equal ones by their numbers
    std::size_t restored = 0;           ///< of `rows`: recomputed from their chunks
    std::vector<HistoryDamage> damage;  ///< chunks that are missing in `rows`
};

/// Checks the rows of a variable. A damaged one is recomputed from its chunk, if this is surely the chunk of
/// the row.
/// @param gaps  all, by their first times
[[nodiscard]] SeriesChunks read_chunks(SQLite::Database& database, const SeriesRow& series,
                                       const HistoryGaps& gaps);
/// Calls `chunk` for each sound row of all variables. @returns false: there are damaged rows
bool each_chunk(SQLite::Database& database, const std::function<void(const ChunkRow&)>& chunk);
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

/// Writes the table of roll-ups anew, from what read_chunks() returns: in a damaged tree, a row with a
/// damaged key is not found, and it hides others.
void rebuild_rollups(SQLite::Database& database, const std::vector<SeriesRow>& all, const HistoryGaps& gaps);

/// Gives all rows of gaps, variables and roll-ups sums, as they are.
void add_sums(SQLite::Database& database);
/// Sets all digests to what the tables have.
/// @param incomplete  variables that keep their digests: it goes on to show that chunks are missing
void count_rows(SQLite::Database& database, HistoryState& state, const std::set<SeriesId>& incomplete = {});

}  // namespace takt::store
