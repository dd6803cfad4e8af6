// Times are stored in milliseconds. Table `rollup` has a small row for each chunk, apart from the chunks'
// bytes: a query over months reads rows side by side, not one page for each. Tables with bytes have a rowid:
// in a WITHOUT ROWID table a row of more than a quarter of a page takes overflow pages.
//
// Version 2 adds sums (history_sums.hpp). Sums of chunks bind their bytes to their number and variable. An
// upgrade does not read the chunks: those of version 1 keep the default, which is "no sum".
#include "history/history_schema.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "history/history_bytes.hpp"
#include "history/history_chunks.hpp"
#include "history/history_tables.hpp"

namespace takt::store {
namespace {

constexpr int kHistoryApplication = 0x546B'4869;  // "TkHi"
constexpr int kHistoryVersion = 2;

constexpr const char* kHistoryTables = R"(
CREATE TABLE series (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, device TEXT NOT NULL,
                     type TEXT NOT NULL, scaled INTEGER NOT NULL, unit TEXT NOT NULL);
CREATE TABLE chunk (id INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE rollup (series INTEGER NOT NULL, t0 INTEGER NOT NULL, chunk INTEGER NOT NULL,
                     t1 INTEGER NOT NULL, open INTEGER NOT NULL, samples INTEGER NOT NULL,
                     quality INTEGER NOT NULL, reason INTEGER NOT NULL, flags INTEGER NOT NULL,
                     numbers INTEGER NOT NULL, first_t INTEGER, first REAL, min_t INTEGER, min REAL,
                     max_t INTEGER, max REAL, last_t INTEGER, last REAL, area REAL, drawn REAL NOT NULL,
                     good REAL NOT NULL,
                     PRIMARY KEY (series, t0, chunk)) WITHOUT ROWID;
CREATE TABLE gap (id INTEGER PRIMARY KEY, first INTEGER NOT NULL, last INTEGER NOT NULL,
                  cause INTEGER NOT NULL, samples INTEGER NOT NULL);
CREATE TABLE log (id INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE state (id INTEGER PRIMARY KEY CHECK (id = 1), journal INTEGER, sequence INTEGER,
                    known_until INTEGER);
)";

struct Index {
    const char* name;
    const char* create;
    const char* columns;  ///< that an entry has
    const char* table;
    const char* condition;      ///< of a partial index
    const char* row_condition;  ///< the same, in a form that does not use the index
};
constexpr Index kIndexes[] = {
    {"rollup_by_end", "CREATE INDEX rollup_by_end ON rollup (t1)", "t1, series, t0, chunk", "rollup", "", ""},
    {"rollup_open", "CREATE INDEX rollup_open ON rollup (open) WHERE open = 1", "open, series, t0, chunk",
     "rollup", " WHERE open = 1", " WHERE +open = 1"},
    {"gap_by_end", "CREATE INDEX gap_by_end ON gap (last)", "last, id", "gap", "", ""},
};

// -2 is no sum: a damaged record that lacks the column is not taken for one of version 1 (-1).
constexpr const char* kSumColumns = R"(
ALTER TABLE series ADD COLUMN chunks INTEGER NOT NULL DEFAULT -2;
ALTER TABLE series ADD COLUMN chunk_sum INTEGER NOT NULL DEFAULT -2;
ALTER TABLE series ADD COLUMN sum INTEGER NOT NULL DEFAULT -2;
ALTER TABLE chunk ADD COLUMN series INTEGER NOT NULL DEFAULT -1;
ALTER TABLE chunk ADD COLUMN sum INTEGER NOT NULL DEFAULT -1;
ALTER TABLE rollup ADD COLUMN sum INTEGER NOT NULL DEFAULT -2;
ALTER TABLE gap ADD COLUMN sum INTEGER NOT NULL DEFAULT -2;
ALTER TABLE state ADD COLUMN log_rows INTEGER NOT NULL DEFAULT -2;
ALTER TABLE state ADD COLUMN log_sum INTEGER NOT NULL DEFAULT -2;
ALTER TABLE state ADD COLUMN gaps INTEGER NOT NULL DEFAULT -2;
ALTER TABLE state ADD COLUMN gap_sum INTEGER NOT NULL DEFAULT -2;
ALTER TABLE state ADD COLUMN all_series INTEGER NOT NULL DEFAULT -2;
ALTER TABLE state ADD COLUMN series_sum INTEGER NOT NULL DEFAULT -2;
ALTER TABLE state ADD COLUMN sum INTEGER NOT NULL DEFAULT -2;
)";

// Columns by name: another process may upgrade the file meanwhile.
constexpr const char* kViews = R"(
CREATE TEMP VIEW series AS SELECT id, name, device, type, scaled, unit, -1 AS chunks, -1 AS chunk_sum,
  -1 AS sum FROM main.series;
CREATE TEMP VIEW chunk AS SELECT id, data, -1 AS series, -1 AS sum FROM main.chunk;
CREATE TEMP VIEW rollup AS SELECT series, t0, chunk, t1, open, samples, quality, reason, flags, numbers,
  first_t, first, min_t, min, max_t, max, last_t, last, area, drawn, good, -1 AS sum FROM main.rollup;
CREATE TEMP VIEW gap AS SELECT id, first, last, cause, samples, -1 AS sum FROM main.gap;
CREATE TEMP VIEW state AS SELECT id, journal, sequence, known_until, -1 AS log_rows, -1 AS log_sum,
  -1 AS gaps, -1 AS gap_sum, -1 AS all_series, -1 AS series_sum, -1 AS sum FROM main.state;
)";

int version_of(SQLite::Database& database) {
    return database.execAndGet("PRAGMA user_version").getInt();
}

// A damaged version number must not switch the checks off.
bool has_sums(SQLite::Database& database) {
    return database.execAndGet("SELECT count(*) FROM pragma_table_info('state') WHERE name = 'sum'")
               .getInt() > 0;
}

/// The number of entries, and the sum of each column.
struct IndexDigest {
    std::int64_t entries = 0;
    std::array<std::int64_t, 4> sums{};

    friend bool operator==(const IndexDigest&, const IndexDigest&) = default;
};

/// @param columns  how many of the query count
IndexDigest digest_of(SQLite::Database& database, const std::string& query, int columns) {
    SQLite::Statement select(database, query);
    IndexDigest digest;
    while (select.executeStep()) {
        ++digest.entries;
        for (int i = 0; i < columns; ++i) {
            auto& sum = digest.sums[static_cast<std::size_t>(i)];
            sum = wrapped_sum(sum, select.getColumn(i).getInt64());
        }
    }
    return digest;
}

// The column `sum` is in no index, so SQLite reads the table.
bool is_sound(SQLite::Database& database, const Index& index) {
    const auto columns = 1 + static_cast<int>(std::ranges::count(std::string_view(index.columns), ','));
    const auto select = std::string("SELECT ") + index.columns;
    const auto from = std::string(" FROM ") + index.table;
    const auto rows =
        digest_of(database, select + ", sum" + from + " NOT INDEXED" + index.row_condition, columns);
    try {
        return digest_of(database, select + from + " INDEXED BY " + index.name + index.condition, columns) ==
               rows;
    } catch (const SQLite::Exception&) {
        return false;
    }
}

// DROP INDEX and REINDEX walk the old pages, and fail at a damaged one. So the index is taken out of the
// schema. Its pages are not used again.
void rebuild(SQLite::Database& database, const Index& index) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    database.exec("PRAGMA writable_schema = ON");
    database.exec(std::string("DELETE FROM sqlite_master WHERE type = 'index' AND name = '") + index.name +
                  "'");
    database.exec("PRAGMA writable_schema = RESET");
    database.exec(index.create);
    transaction.commit();
}

void set_version(SQLite::Database& database) {
    database.exec("PRAGMA user_version = " + std::to_string(kHistoryVersion));
}

}  // namespace

void make_history_tables(SQLite::Database& database) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    database.exec(kHistoryTables);
    for (const Index& index : kIndexes) database.exec(index.create);
    database.exec(kSumColumns);
    write_state(database, {});
    database.exec("PRAGMA application_id = " + std::to_string(kHistoryApplication));
    set_version(database);
    transaction.commit();
}

bool is_empty_history(SQLite::Database& database) {
    return database.execAndGet("PRAGMA application_id").getInt() == 0 &&
           database.execAndGet("SELECT count(*) FROM sqlite_master").getInt() == 0;
}

Result<void> check_history(SQLite::Database& database, const std::string& path) {
    const int application = database.execAndGet("PRAGMA application_id").getInt();
    const int version = version_of(database);
    if (application != kHistoryApplication || version > kHistoryVersion) return fail(Code::unsupported, path);
    if (version < 1 || (version >= 2 && !has_sums(database))) return fail(Code::malformed, path);
    return {};
}

void upgrade_history(SQLite::Database& database) {
    if (version_of(database) == kHistoryVersion) return;
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    if (!has_sums(database)) {
        HistoryState state = read_state_of_version_1(database);
        database.exec(kSumColumns);
        database.exec("UPDATE series SET sum = -1");
        add_sums(database);
        count_rows(database, state);
        write_state(database, state);
    }
    set_version(database);
    transaction.commit();
}

void repair_indexes(SQLite::Database& database) {
    for (const Index& index : kIndexes)
        if (!is_sound(database, index)) rebuild(database, index);
}

void view_history(SQLite::Database& database) {
    if (!has_sums(database)) database.exec(kViews);
}

}  // namespace takt::store
