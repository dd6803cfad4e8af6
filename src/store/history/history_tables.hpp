// The tables of a history file: state, variables, gaps and log. All functions throw SQLite::Exception.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "history/history_log.hpp"
#include "history/history_summary.hpp"
#include "history/history_sums.hpp"
#include "registers/database.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::store {

/// The bytes of a column; empty if it has none.
[[nodiscard]] std::vector<std::uint8_t> bytes_of(const SQLite::Column& column);
/// The bytes must outlive the next step of the statement.
void bind_bytes(SQLite::Statement& statement, int index, const std::vector<std::uint8_t>& bytes);

/// The last record of the journal that is in, and the time up to which the history is complete.
struct HistoryState {
    std::optional<HistoryPosition> position;
    std::int64_t known_until_ns = INT64_MIN;
    RowsDigest log;  ///< its sums are those that end the rows
    RowsDigest gaps;
    RowsDigest series;
    bool damaged = false;  ///< all else is unknown
};
/// @returns a damaged one also if there is none
[[nodiscard]] HistoryState read_state(SQLite::Database& database);
/// Of a file without sums.
[[nodiscard]] HistoryState read_state_of_version_1(SQLite::Database& database);
void write_state(SQLite::Database& database, const HistoryState& state);

/// A row of the table of variables.
struct SeriesRow {
    HistorySeriesInfo info;
    std::string type;   ///< as it is stored
    RowsDigest chunks;  ///< rows of roll-ups
    std::int64_t sum = kNoSum;

    /// Whether the row has its sum, or no sum.
    [[nodiscard]] bool is_good() const;
};
/// All rows, also damaged ones, by name.
[[nodiscard]] std::vector<SeriesRow> read_series_rows(SQLite::Database& database);
[[nodiscard]] std::optional<SeriesRow> read_series_row(SQLite::Database& database, SeriesId id);
/// Writes properties, digest and sum of a row that exists.
void write_series_row(SQLite::Database& database, HistoryState& state, const SeriesRow& row);
/// What a reader takes from the table of variables.
struct ReadSeries {
    std::vector<SeriesRow> rows;  ///< good ones, by name
    /// Of the others, with the number and the name where the index of the names has them.
    std::vector<HistoryDamage> damage;
};
/// Reads what is left of a damaged table. The index of the names is a second copy of numbers and names: a row
/// whose name alone is damaged gets it from there.
[[nodiscard]] ReadSeries read_series(SQLite::Database& database, const HistoryState& state);
/// Gives rows whose name alone is damaged the name of the index. @returns whether there are any
bool restore_names(SQLite::Database& database, std::vector<SeriesRow>& rows);
/// Writes the names of these rows, and builds the index of the names again.
void repair_series(SQLite::Database& database, const std::vector<SeriesRow>& rows);
/// Adds a variable, or gives it other properties.
[[nodiscard]] SeriesId write_series(SQLite::Database& database, HistoryState& state,
                                    const HistorySeries& series);
/// Damaged rows, and whether rows are missing.
[[nodiscard]] std::vector<HistoryDamage> damage_of(const std::vector<SeriesRow>& rows,
                                                   const HistoryState& state);

void write_gap(SQLite::Database& database, HistoryState& state, const HistoryGap& gap);
struct ReadGaps {
    HistoryGaps gaps;  ///< by their first times
    std::vector<HistoryDamage> damage;
};
[[nodiscard]] ReadGaps read_gaps(SQLite::Database& database, const HistoryState& state);
/// Those that overlap [from, to].
[[nodiscard]] HistoryGaps gaps_in(const HistoryGaps& gaps, std::int64_t from_ns, std::int64_t to_ns);
void drop_gaps(SQLite::Database& database, HistoryState& state, std::int64_t cutoff_ns);
/// Deletes damaged rows and builds the indexes again.
void repair_gaps(SQLite::Database& database);
/// Gives rows without a sum their sum.
void add_gap_sums(SQLite::Database& database);

/// @param row  as encode_log() returns it
void write_log(SQLite::Database& database, HistoryState& state, const std::vector<std::uint8_t>& row);
/// The samples of the log, and its damaged or missing rows.
/// @param from_ns  a time before the log; nothing: unknown
[[nodiscard]] DecodedLog read_log(SQLite::Database& database, const HistoryState& state,
                                  std::optional<std::int64_t> from_ns);
/// The end of the newest chunk; nothing: there is none, or the index that has it is damaged.
[[nodiscard]] std::optional<std::int64_t> newest_chunk_end(SQLite::Database& database);
[[nodiscard]] RowsDigest digest_of_log(SQLite::Database& database);
void clear_log(SQLite::Database& database, HistoryState& state);

struct HistoryPages {
    std::uint64_t used_bytes = 0;
    std::uint64_t file_bytes = 0;
};
[[nodiscard]] HistoryPages pages_of(SQLite::Database& database);

}  // namespace takt::store
