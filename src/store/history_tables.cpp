// Times are stored in milliseconds. Table `rollup` has a small row for each chunk, apart from the chunks'
// bytes: a query over months reads rows side by side, not one page for each. Tables with bytes have a rowid:
// in a WITHOUT ROWID table a row of more than a quarter of a page takes overflow pages.
#include "history_tables.hpp"

#include <string>

#include "history_bytes.hpp"
#include "takt/store/history_codec.hpp"

namespace takt::store {
namespace {

constexpr int kHistoryApplication = 0x546B'4869;  // "TkHi"
constexpr int kHistoryVersion = 1;

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
CREATE INDEX rollup_by_end ON rollup (t1);
CREATE INDEX rollup_open ON rollup (open) WHERE open = 1;
CREATE TABLE gap (id INTEGER PRIMARY KEY, first INTEGER NOT NULL, last INTEGER NOT NULL,
                  cause INTEGER NOT NULL, samples INTEGER NOT NULL);
CREATE INDEX gap_by_end ON gap (last);
CREATE TABLE log (id INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE state (id INTEGER PRIMARY KEY CHECK (id = 1), journal INTEGER, sequence INTEGER,
                    known_until INTEGER);
)";

constexpr const char* kRowColumns =
    "series, t0, chunk, t1, open, samples, quality, reason, flags, numbers, first_t, first, min_t, min, "
    "max_t,"
    " max, last_t, last, area, drawn, good";

enum Flag : std::uint8_t { kMixed = 1, kEndsGood = 2, kEndsWithNumber = 4 };

std::vector<std::uint8_t> bytes_of(const SQLite::Column& column) {
    const auto* const data = static_cast<const std::uint8_t*>(column.getBlob());
    const auto size = static_cast<std::size_t>(column.getBytes());
    return data == nullptr ? std::vector<std::uint8_t>() : std::vector<std::uint8_t>(data, data + size);
}

void bind_bytes(SQLite::Statement& statement, int index, const std::vector<std::uint8_t>& bytes) {
    statement.bindNoCopy(index, bytes.data(), static_cast<int>(bytes.size()));
}

void bind_point(SQLite::Statement& statement, int index, const HistorySummary& summary,
                const HistoryPoint& point) {
    if (summary.numbers == 0) {
        statement.bind(index);
        statement.bind(index + 1);
        return;
    }
    statement.bind(index, milliseconds(point.time_ns));
    statement.bind(index + 1, point.value);
}

HistoryPoint point_of(SQLite::Statement& row, int index) {
    return {nanoseconds(row.getColumn(index).getInt64()), row.getColumn(index + 1).getDouble(), {}};
}

ChunkRow chunk_row(SQLite::Statement& row) {
    ChunkRow chunk;
    chunk.series = SeriesId{row.getColumn(0).getUInt()};
    chunk.id = row.getColumn(2).getInt64();
    chunk.open = row.getColumn(4).getInt() != 0;
    auto& summary = chunk.summary;
    summary.begin_ns = nanoseconds(row.getColumn(1).getInt64());
    summary.end_ns = nanoseconds(row.getColumn(3).getInt64());
    summary.samples = static_cast<std::uint64_t>(row.getColumn(5).getInt64());
    summary.quality = static_cast<value::Quality>(row.getColumn(6).getInt());
    summary.reason = static_cast<value::Reason>(row.getColumn(7).getInt());
    const int flags = row.getColumn(8).getInt();
    summary.mixed = (flags & kMixed) != 0;
    summary.ends_good = (flags & kEndsGood) != 0;
    summary.ends_with_number = (flags & kEndsWithNumber) != 0;
    summary.numbers = static_cast<std::uint64_t>(row.getColumn(9).getInt64());
    summary.first = point_of(row, 10);
    summary.min = point_of(row, 12);
    summary.max = point_of(row, 14);
    summary.last = point_of(row, 16);
    summary.area = row.getColumn(18).getDouble();
    summary.drawn_s = row.getColumn(19).getDouble();
    summary.good_s = row.getColumn(20).getDouble();
    return chunk;
}

std::vector<std::uint8_t> read_blob(SQLite::Database& database, const char* query, std::int64_t id) {
    SQLite::Statement select(database, query);
    select.bind(1, id);
    return select.executeStep() ? bytes_of(select.getColumn(0)) : std::vector<std::uint8_t>();
}

void execute(SQLite::Statement& statement) {
    statement.exec();
    statement.reset();
}

}  // namespace

std::string_view name(HistoryPart part) {
    switch (part) {
        case HistoryPart::log: return "log";
        case HistoryPart::chunk: return "chunk";
        case HistoryPart::rollup: return "rollup";
        case HistoryPart::gap: return "gap";
        case HistoryPart::series: return "series";
        case HistoryPart::state: return "state";
        case HistoryPart::recorded: return "recorded";
    }
    return "other";
}

void make_history_tables(SQLite::Database& database) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    database.exec(kHistoryTables);
    database.exec("INSERT INTO state VALUES (1, NULL, NULL, NULL);PRAGMA application_id = " +
                  std::to_string(kHistoryApplication) +
                  ";PRAGMA user_version = " + std::to_string(kHistoryVersion));
    transaction.commit();
}

bool is_empty_history(SQLite::Database& database) {
    return database.execAndGet("PRAGMA application_id").getInt() == 0 &&
           database.execAndGet("SELECT count(*) FROM sqlite_master").getInt() == 0;
}

Result<void> check_history(SQLite::Database& database, const std::string& path) {
    const int application = database.execAndGet("PRAGMA application_id").getInt();
    const int version = database.execAndGet("PRAGMA user_version").getInt();
    if (application != kHistoryApplication || version > kHistoryVersion) return fail(Code::unsupported, path);
    if (version < 1) return fail(Code::malformed, path);
    return {};
}

HistoryState read_state(SQLite::Database& database) {
    HistoryState state;
    SQLite::Statement select(database, "SELECT journal, sequence, known_until FROM state");
    if (!select.executeStep()) return state;
    if (!select.isColumnNull(0))
        state.position = HistoryPosition{static_cast<std::uint64_t>(select.getColumn(0).getInt64()),
                                         static_cast<std::uint64_t>(select.getColumn(1).getInt64())};
    if (!select.isColumnNull(2)) state.known_until_ns = nanoseconds(select.getColumn(2).getInt64());
    return state;
}

void write_state(SQLite::Database& database, const HistoryState& state) {
    SQLite::Statement update(
        database, "INSERT OR REPLACE INTO state (id, journal, sequence, known_until) VALUES (1, ?, ?, ?)");
    if (state.position) {
        update.bind(1, static_cast<std::int64_t>(state.position->journal));
        update.bind(2, static_cast<std::int64_t>(state.position->sequence));
    }
    if (state.known_until_ns != INT64_MIN) update.bind(3, milliseconds(state.known_until_ns));
    update.exec();
}

std::vector<HistorySeriesInfo> read_series(SQLite::Database& database) {
    SQLite::Statement select(database,
                             "SELECT id, name, device, type, scaled, unit FROM series ORDER BY name");
    std::vector<HistorySeriesInfo> all;
    while (select.executeStep()) {
        HistorySeriesInfo info;
        info.id = SeriesId{select.getColumn(0).getUInt()};
        info.series.name = select.getColumn(1).getString();
        info.series.device = select.getColumn(2).getString();
        info.series.type = data_type(select.getColumn(3).getString()).value_or(DataType::float64);
        info.series.scaled = select.getColumn(4).getInt() != 0;
        info.series.unit = select.getColumn(5).getString();
        all.push_back(std::move(info));
    }
    return all;
}

SeriesId write_series(SQLite::Database& database, const HistorySeries& series) {
    SQLite::Statement insert(
        database,
        "INSERT INTO series (name, device, type, scaled, unit) VALUES (?, ?, ?, ?, ?)"
        " ON CONFLICT (name) DO UPDATE SET device = excluded.device, type = excluded.type,"
        " scaled = excluded.scaled, unit = excluded.unit RETURNING id");
    insert.bind(1, series.name);
    insert.bind(2, series.device);
    insert.bind(3, std::string(name(series.type)));
    insert.bind(4, series.scaled ? 1 : 0);
    insert.bind(5, series.unit);
    insert.executeStep();
    return SeriesId{insert.getColumn(0).getUInt()};
}

void write_gap(SQLite::Database& database, const HistoryGap& gap) {
    SQLite::Statement insert(database, "INSERT INTO gap (first, last, cause, samples) VALUES (?, ?, ?, ?)");
    insert.bind(1, milliseconds(gap.first_ns));
    insert.bind(2, milliseconds(gap.last_ns));
    insert.bind(3, static_cast<int>(gap.cause));
    insert.bind(4, static_cast<std::int64_t>(gap.samples));
    insert.exec();
}

HistoryGaps read_gaps(SQLite::Database& database, std::int64_t from_ns, std::int64_t to_ns) {
    SQLite::Statement select(database,
                             "SELECT first, last, cause, samples FROM gap WHERE last >= ? AND first <= ?"
                             " ORDER BY first, id");
    select.bind(1, milliseconds(from_ns));
    select.bind(2, milliseconds(to_ns));
    HistoryGaps gaps;
    while (select.executeStep())
        gaps.push_back({nanoseconds(select.getColumn(0).getInt64()),
                        nanoseconds(select.getColumn(1).getInt64()),
                        static_cast<GapCause>(select.getColumn(2).getInt()),
                        static_cast<std::uint64_t>(select.getColumn(3).getInt64())});
    return gaps;
}

ChunkWriter::ChunkWriter(SQLite::Database& database)
    : row_(database, std::string("INSERT INTO rollup (") + kRowColumns +
                         ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      data_(database, "INSERT INTO chunk (id, data) VALUES (?, ?)"),
      erase_row_(database, "DELETE FROM rollup WHERE series = ? AND t0 = ? AND chunk = ?"),
      erase_data_(database, "DELETE FROM chunk WHERE id = ?") {}

void ChunkWriter::write(const ChunkRow& row, const std::vector<std::uint8_t>& data) {
    const auto& summary = row.summary;
    row_.reset();
    row_.bind(1, row.series.value);
    row_.bind(2, milliseconds(summary.begin_ns));
    row_.bind(3, row.id);
    row_.bind(4, milliseconds(summary.end_ns));
    row_.bind(5, row.open ? 1 : 0);
    row_.bind(6, static_cast<std::int64_t>(summary.samples));
    row_.bind(7, static_cast<int>(summary.quality));
    row_.bind(8, static_cast<int>(summary.reason));
    row_.bind(9, (summary.mixed ? kMixed : 0) | (summary.ends_good ? kEndsGood : 0) |
                     (summary.ends_with_number ? kEndsWithNumber : 0));
    row_.bind(10, static_cast<std::int64_t>(summary.numbers));
    bind_point(row_, 11, summary, summary.first);
    bind_point(row_, 13, summary, summary.min);
    bind_point(row_, 15, summary, summary.max);
    bind_point(row_, 17, summary, summary.last);
    row_.bind(19, summary.area);
    row_.bind(20, summary.drawn_s);
    row_.bind(21, summary.good_s);
    execute(row_);
    data_.reset();
    data_.bind(1, row.id);
    bind_bytes(data_, 2, data);
    execute(data_);
}

void ChunkWriter::erase(SeriesId series, std::int64_t begin_ns, std::int64_t id) {
    erase_row_.reset();
    erase_row_.bind(1, series.value);
    erase_row_.bind(2, milliseconds(begin_ns));
    erase_row_.bind(3, id);
    execute(erase_row_);
    erase_data_.reset();
    erase_data_.bind(1, id);
    execute(erase_data_);
}

std::vector<ChunkRow> read_chunks(SQLite::Database& database, SeriesId series, std::int64_t from_ns,
                                  std::int64_t to_ns) {
    SQLite::Statement select(database,
                             std::string("SELECT ") + kRowColumns +
                                 " FROM rollup WHERE series = ? AND t0 >= ? AND t0 <= ? ORDER BY t0, chunk");
    select.bind(1, series.value);
    select.bind(2, milliseconds(from_ns));
    select.bind(3, milliseconds(to_ns - 1));
    std::vector<ChunkRow> chunks;
    while (select.executeStep()) chunks.push_back(chunk_row(select));
    return chunks;
}

std::vector<ChunkRow> read_open_chunks(SQLite::Database& database) {
    SQLite::Statement select(
        database, std::string("SELECT ") + kRowColumns + " FROM rollup WHERE open = 1 ORDER BY chunk");
    std::vector<ChunkRow> chunks;
    while (select.executeStep()) chunks.push_back(chunk_row(select));
    return chunks;
}

std::int64_t last_chunk(SQLite::Database& database) {
    return database.execAndGet("SELECT coalesce(max(id), 0) FROM chunk").getInt64();
}

std::vector<std::uint8_t> read_chunk_data(SQLite::Database& database, std::int64_t id) {
    return read_blob(database, "SELECT data FROM chunk WHERE id = ?", id);
}

Result<std::vector<HistorySample>> read_samples(SQLite::Database& database, const ChunkRow& row) {
    auto samples = decode_history(read_chunk_data(database, row.id));
    if (!samples) return samples;
    const auto& summary = row.summary;
    if (samples->empty() || samples->size() != summary.samples ||
        samples->front().time_ns != summary.begin_ns || samples->back().time_ns != summary.end_ns)
        return fail(Code::malformed);
    return samples;
}

HistoryDamage damage_of(SQLite::Database& database, const ChunkRow& row) {
    HistoryDamage damage{.part = HistoryPart::chunk,
                         .row = row.id,
                         .first_ns = row.summary.begin_ns,
                         .last_ns = row.summary.end_ns,
                         .samples = row.summary.samples};
    for (const auto& info : read_series(database))
        if (info.id == row.series) damage.variable = info.series.name;
    return damage;
}

std::size_t drop_chunks(SQLite::Database& database, std::int64_t cutoff_ns, std::size_t most) {
    SQLite::Statement select(
        database, "SELECT series, t0, chunk FROM rollup WHERE t1 < ? AND open = 0 ORDER BY t1 LIMIT ?");
    select.bind(1, milliseconds(cutoff_ns));
    select.bind(2, static_cast<std::int64_t>(most));
    struct Old {
        SeriesId series;
        std::int64_t begin_ns;
        std::int64_t id;
    };
    std::vector<Old> chunks;
    while (select.executeStep())
        chunks.push_back({SeriesId{select.getColumn(0).getUInt()},
                          nanoseconds(select.getColumn(1).getInt64()), select.getColumn(2).getInt64()});
    ChunkWriter writer(database);
    for (const auto& [series, begin_ns, id] : chunks) writer.erase(series, begin_ns, id);
    return chunks.size();
}

void drop_gaps(SQLite::Database& database, std::int64_t cutoff_ns) {
    SQLite::Statement erase(database, "DELETE FROM gap WHERE last < ?");
    erase.bind(1, milliseconds(cutoff_ns));
    erase.exec();
}

void write_log(SQLite::Database& database, const std::vector<std::uint8_t>& row) {
    SQLite::Statement insert(database, "INSERT INTO log (data) VALUES (?)");
    bind_bytes(insert, 1, row);
    insert.exec();
}

std::vector<LogRow> read_log(SQLite::Database& database) {
    SQLite::Statement select(database, "SELECT id, data FROM log ORDER BY id");
    std::vector<LogRow> rows;
    while (select.executeStep())
        rows.push_back({select.getColumn(0).getInt64(), bytes_of(select.getColumn(1))});
    return rows;
}

// The log is newer than the chunks that are closed, and older than the last commit.
DecodedLog read_logged(SQLite::Database& database) {
    const auto rows = read_log(database);
    if (rows.empty()) return {};
    const auto until = read_state(database).known_until_ns;
    SQLite::Statement select(database, "SELECT max(t1) FROM rollup");
    const bool has_chunks = select.executeStep() && !select.isColumnNull(0);
    return decode_log(rows, has_chunks ? nanoseconds(select.getColumn(0).getInt64()) : until, until);
}

void clear_log(SQLite::Database& database) {
    database.exec("DELETE FROM log");
}

HistoryPages pages_of(SQLite::Database& database) {
    const auto number = [&database](const char* query) {
        return static_cast<std::uint64_t>(database.execAndGet(query).getInt64());
    };
    const std::uint64_t size = number("PRAGMA page_size");
    const std::uint64_t count = number("PRAGMA page_count");
    return {(count - number("PRAGMA freelist_count")) * size, count * size};
}

}  // namespace takt::store
