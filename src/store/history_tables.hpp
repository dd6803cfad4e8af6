// The tables of a history file. All functions throw SQLite::Exception.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "database.hpp"
#include "history_log.hpp"
#include "history_summary.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::store {

/// A chunk's row in the table of roll-ups.
struct ChunkRow {
    std::int64_t id = 0;
    SeriesId series;
    bool open = false;  ///< it is replaced by a later one
    HistorySummary summary;
};

inline constexpr std::int64_t kHour = 3'600'000'000'000;

/// Creates the tables in an empty file.
void make_history_tables(SQLite::Database& database);
/// Whether it is a database without tables and of no program.
[[nodiscard]] bool is_empty_history(SQLite::Database& database);
/// @returns malformed: not a history; unsupported: of a newer version
[[nodiscard]] Result<void> check_history(SQLite::Database& database, const std::string& path);

/// The last record of the journal that is in, and the time up to which the history is complete.
struct HistoryState {
    std::optional<HistoryPosition> position;
    std::int64_t known_until_ns = INT64_MIN;
};
[[nodiscard]] HistoryState read_state(SQLite::Database& database);
void write_state(SQLite::Database& database, const HistoryState& state);

[[nodiscard]] std::vector<HistorySeriesInfo> read_series(SQLite::Database& database);
[[nodiscard]] SeriesId write_series(SQLite::Database& database, const HistorySeries& series);

void write_gap(SQLite::Database& database, const HistoryGap& gap);
/// The gaps that overlap [from, to], by their first times.
[[nodiscard]] HistoryGaps read_gaps(SQLite::Database& database, std::int64_t from_ns, std::int64_t to_ns);

/// Prepared once: the row and the bytes of chunks.
class ChunkWriter {
public:
    explicit ChunkWriter(SQLite::Database& database);
    void write(const ChunkRow& row, const std::vector<std::uint8_t>& data);
    void erase(SeriesId series, std::int64_t begin_ns, std::int64_t id);

private:
    SQLite::Statement row_;
    SQLite::Statement data_;
    SQLite::Statement erase_row_;
    SQLite::Statement erase_data_;
};

/// The rows of chunks of a series that begin in [from, to), in the order of their begin; of equal ones in the
/// order of their numbers.
[[nodiscard]] std::vector<ChunkRow> read_chunks(SQLite::Database& database, SeriesId series,
                                                std::int64_t from_ns, std::int64_t to_ns);
/// The open chunks of all series.
[[nodiscard]] std::vector<ChunkRow> read_open_chunks(SQLite::Database& database);
/// The greatest number of a chunk; 0: there is none.
[[nodiscard]] std::int64_t last_chunk(SQLite::Database& database);
/// Empty where there is no such chunk.
[[nodiscard]] std::vector<std::uint8_t> read_chunk_data(SQLite::Database& database, std::int64_t id);

/// The samples of a chunk, in order of time.
/// @returns malformed: they are damaged, or not those of the row
[[nodiscard]] Result<std::vector<HistorySample>> read_samples(SQLite::Database& database,
                                                              const ChunkRow& row);
/// The damage of a chunk, with the name of its variable.
[[nodiscard]] HistoryDamage damage_of(SQLite::Database& database, const ChunkRow& row);

/// Deletes up to `most` closed chunks, the oldest first, that end before `cutoff_ns`. @returns how many
[[nodiscard]] std::size_t drop_chunks(SQLite::Database& database, std::int64_t cutoff_ns, std::size_t most);
void drop_gaps(SQLite::Database& database, std::int64_t cutoff_ns);

void write_log(SQLite::Database& database, const std::vector<std::uint8_t>& row);
/// The rows, in the order of their numbers.
[[nodiscard]] std::vector<LogRow> read_log(SQLite::Database& database);
/// The samples of the log, and its damaged rows.
[[nodiscard]] DecodedLog read_logged(SQLite::Database& database);
void clear_log(SQLite::Database& database);

struct HistoryPages {
    std::uint64_t used_bytes = 0;
    std::uint64_t file_bytes = 0;
};
[[nodiscard]] HistoryPages pages_of(SQLite::Database& database);

}  // namespace takt::store
