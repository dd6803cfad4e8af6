// A roll-up that does not have its sum is recomputed from its chunk. The sum of a chunk binds its bytes to
// its number and variable, so no samples come under another name. A digest of each variable shows rows that
// are missing, also where a damaged page leads a search astray: then the whole table is read.
#include "history/history_chunks.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "takt/store/history_codec.hpp"

namespace takt::store {
namespace {

constexpr const char* kRowColumns =
    "series, t0, chunk, t1, open, samples, quality, reason, flags, numbers, first_t, first, min_t, min, "
    "max_t,"
    " max, last_t, last, area, drawn, good, sum";
constexpr int kSumColumn = 21;

enum Flag : std::uint8_t { kMixed = 1, kEndsGood = 2, kEndsWithNumber = 4 };

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

std::int64_t flags_of(const HistorySummary& summary) {
    return (summary.mixed ? kMixed : 0) | (summary.ends_good ? kEndsGood : 0) |
           (summary.ends_with_number ? kEndsWithNumber : 0);
}

std::int64_t sum_of(const ChunkRow& row) {
    const auto& summary = row.summary;
    RowSum sum('r');
    sum.add(std::int64_t{row.series.value}).add(milliseconds(summary.begin_ns)).add(row.id);
    sum.add(milliseconds(summary.end_ns)).add(std::int64_t{row.open});
    sum.add(static_cast<std::int64_t>(summary.samples)).add(static_cast<std::int64_t>(summary.quality));
    sum.add(static_cast<std::int64_t>(summary.reason)).add(flags_of(summary));
    sum.add(static_cast<std::int64_t>(summary.numbers));
    for (const auto* const point : {&summary.first, &summary.min, &summary.max, &summary.last}) {
        if (summary.numbers == 0) break;
        sum.add(milliseconds(point->time_ns)).add(point->value);
    }
    return sum.add(summary.area).add(summary.drawn_s).add(summary.good_s).value();
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

/// Binds the bytes to the number and the variable. The bytes end with a sum of their own.
std::int64_t chunk_sum(std::int64_t id, std::int64_t series, Bytes data) {
    if (data.size() < kCrc32cBytes) return kNoSum;
    const auto checksum = LittleEndianReader(data.last(kCrc32cBytes)).take<std::uint32_t>();
    return RowSum('c').add(id).add(series).add(std::int64_t{checksum}).value();
}

/// A row of the table of chunks.
struct Chunk {
    std::int64_t id = 0;
    std::int64_t series = kNoSum;
    std::int64_t sum = kNoSum;
    std::vector<std::uint8_t> data;

    [[nodiscard]] bool is_bound() const { return series != kNoSum || sum != kNoSum; }
    /// Nothing: they are damaged, or there are none.
    [[nodiscard]] std::optional<std::vector<HistorySample>> samples() const {
        if (is_bound() && sum != chunk_sum(id, series, data)) return {};
        auto samples = decode_history(data);
        if (!samples || samples->empty()) return {};
        return std::move(*samples);
    }
};

Chunk chunk_of(SQLite::Statement& row) {
    return {row.getColumn(0).getInt64(), row.getColumn(1).getInt64(), row.getColumn(2).getInt64(),
            bytes_of(row.getColumn(3))};
}

Chunk read_chunk(SQLite::Database& database, std::int64_t id) {
    SQLite::Statement select(database, "SELECT id, series, sum, data FROM chunk WHERE id = ?");
    select.bind(1, id);
    Chunk chunk;
    unless_damaged([&] {
        if (select.executeStep()) chunk = chunk_of(select);
        return false;
    });
    return chunk;
}

/// A row of roll-ups as it is in the file.
struct StoredRow {
    ChunkRow row;
    std::int64_t sum = kNoSum;

    [[nodiscard]] bool is_good() const { return sum == kNoSum || sum == sum_of(row); }
};

StoredRow stored_row(SQLite::Statement& row) {
    return {chunk_row(row), row.getColumn(kSumColumn).getInt64()};
}

// A chunk of version 1 is not bound to a variable: then the recomputed row must have the sum of the damaged
// one, or its values, if only the sum is damaged.
std::optional<ChunkRow> restored(SQLite::Database& database, const StoredRow& bad, const HistoryGaps& gaps) {
    const Chunk chunk = read_chunk(database, bad.row.id);
    const auto samples = chunk.samples();
    if (!samples) return {};
    ChunkRow row{bad.row.id, bad.row.series, bad.row.open, summary_of(*samples, gaps)};
    if (chunk.is_bound()) row.series = SeriesId{static_cast<std::uint32_t>(chunk.series)};
    ChunkRow other = row;
    other.open = !row.open;
    if (sum_of(other) == bad.sum) return other;
    const bool same = sum_of(row) == bad.sum || sum_of(row) == sum_of(bad.row);
    return same || chunk.is_bound() ? std::optional(row) : std::nullopt;
}

std::string insert_row(const std::string& table) {
    return "INSERT INTO " + table + " (" + kRowColumns +
           ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)";
}

/// @returns the sum of the row
std::int64_t write_row(SQLite::Statement& insert, const ChunkRow& row) {
    const auto& summary = row.summary;
    const std::int64_t sum = sum_of(row);
    insert.reset();
    insert.bind(1, row.series.value);
    insert.bind(2, milliseconds(summary.begin_ns));
    insert.bind(3, row.id);
    insert.bind(4, milliseconds(summary.end_ns));
    insert.bind(5, row.open ? 1 : 0);
    insert.bind(6, static_cast<std::int64_t>(summary.samples));
    insert.bind(7, static_cast<int>(summary.quality));
    insert.bind(8, static_cast<int>(summary.reason));
    insert.bind(9, flags_of(summary));
    insert.bind(10, static_cast<std::int64_t>(summary.numbers));
    bind_point(insert, 11, summary, summary.first);
    bind_point(insert, 13, summary, summary.min);
    bind_point(insert, 15, summary, summary.max);
    bind_point(insert, 17, summary, summary.last);
    insert.bind(19, summary.area);
    insert.bind(20, summary.drawn_s);
    insert.bind(21, summary.good_s);
    insert.bind(22, sum);
    insert.exec();
    insert.reset();
    return sum;
}

/// Collects the chunks of a variable.
class ChunkCollector {
public:
    ChunkCollector(SQLite::Database& database, const SeriesRow& series, const HistoryGaps& gaps)
        : database_(database), series_(series), gaps_(gaps) {}

    void add_rows(const char* condition) {
        SQLite::Statement select(database_,
                                 std::string("SELECT ") + kRowColumns + " FROM rollup WHERE " + condition);
        select.bind(1, series_.info.id.value);
        unless_damaged([&] {
            if (!select.executeStep()) return false;
            add(stored_row(select));
            return true;
        });
        order();
    }
    /// The chunks that no row names. There may be no more than there were rows.
    void add_chunks() {
        SQLite::Statement select(database_, "SELECT id, series, sum, data FROM chunk WHERE series = ?");
        select.bind(1, series_.info.id.value);
        std::set<std::int64_t> known;
        for (const auto& row : result_.rows) known.insert(row.id);
        std::vector<ChunkRow> found;
        unless_damaged([&] {
            if (!select.executeStep()) return false;
            const Chunk chunk = chunk_of(select);
            const auto samples = known.contains(chunk.id) ? std::nullopt : chunk.samples();
            if (samples) found.push_back({chunk.id, series_.info.id, false, summary_of(*samples, gaps_)});
            return true;
        });
        if (std::cmp_greater(result_.rows.size() + found.size(), series_.chunks.rows)) return;
        for (const auto& row : found) {
            result_.rows.push_back(row);
            ++result_.restored;
        }
        order();
    }
    /// Whether these are the rows that were written, as far as that is known.
    [[nodiscard]] bool is_complete() const {
        RowsDigest digest;
        for (const auto& row : result_.rows) digest.add(sum_of(row));
        return !series_.is_good() || !series_.chunks.is_known() || digest == series_.chunks;
    }
    SeriesChunks take() && { return std::move(result_); }

private:
    void add(const StoredRow& stored) {
        if (stored.is_good()) {
            if (stored.row.series == series_.info.id) result_.rows.push_back(stored.row);
            return;
        }
        const auto row = restored(database_, stored, gaps_);
        if (!row || row->series != series_.info.id) return;
        ++result_.restored;
        result_.rows.push_back(*row);
    }
    void order() {
        auto& rows = result_.rows;
        std::ranges::stable_sort(rows, {}, &ChunkRow::id);
        const auto doubled = std::ranges::unique(rows, {}, &ChunkRow::id);
        rows.erase(doubled.begin(), doubled.end());
        std::ranges::stable_sort(rows, {}, [](const ChunkRow& row) { return row.summary.begin_ns; });
    }

    SQLite::Database& database_;
    const SeriesRow& series_;
    const HistoryGaps& gaps_;
    SeriesChunks result_;
};

}  // namespace

ChunkWriter::ChunkWriter(SQLite::Database& database)
    : database_(database),
      row_(database, insert_row("rollup")),
      data_(database, "INSERT INTO chunk (id, data, series, sum) VALUES (?, ?, ?, ?)"),
      erase_row_(database, "DELETE FROM rollup WHERE series = ? AND t0 = ? AND chunk = ? RETURNING sum"),
      erase_data_(database, "DELETE FROM chunk WHERE id = ?") {}

void ChunkWriter::write(const ChunkRow& row, const std::vector<std::uint8_t>& data) {
    changes_[row.series].add(write_row(row_, row));
    data_.reset();
    data_.bind(1, row.id);
    bind_bytes(data_, 2, data);
    data_.bind(3, row.series.value);
    data_.bind(4, chunk_sum(row.id, row.series.value, data));
    data_.exec();
    data_.reset();
}

void ChunkWriter::erase(SeriesId series, std::int64_t begin_ns, std::int64_t id) {
    erase_row_.reset();
    erase_row_.bind(1, series.value);
    erase_row_.bind(2, milliseconds(begin_ns));
    erase_row_.bind(3, id);
    while (erase_row_.executeStep()) changes_[series].remove(erase_row_.getColumn(0).getInt64());
    erase_row_.reset();
    erase_data_.reset();
    erase_data_.bind(1, id);
    erase_data_.exec();
    erase_data_.reset();
}

// The digest of a damaged row is not known: that row is left as it is.
void ChunkWriter::finish(HistoryState& state) {
    for (const auto& [series, change] : std::exchange(changes_, {})) {
        auto row = read_series_row(database_, series);
        if (!row || !row->is_good()) continue;
        row->chunks.rows += change.rows;
        row->chunks.sum += change.sum;
        write_series_row(database_, state, *row);
    }
}

SeriesChunks read_chunks(SQLite::Database& database, const SeriesRow& series, const HistoryGaps& gaps) {
    ChunkCollector collector(database, series, gaps);
    collector.add_rows("series = ?");
    if (collector.is_complete()) return std::move(collector).take();
    collector.add_rows("? >= 0");  // all rows, without a search
    if (!collector.is_complete()) collector.add_chunks();
    const bool complete = collector.is_complete();
    auto result = std::move(collector).take();
    if (!complete)
        result.damage.push_back({.part = HistoryPart::rollup, .variable = series.info.series.name});
    return result;
}

bool each_chunk(SQLite::Database& database, const std::function<void(const ChunkRow&)>& chunk) {
    SQLite::Statement select(database, std::string("SELECT ") + kRowColumns + " FROM rollup NOT INDEXED");
    bool sound = true;
    while (select.executeStep()) {
        const auto stored = stored_row(select);
        if (stored.is_good())
            chunk(stored.row);
        else
            sound = false;
    }
    return sound;
}

std::int64_t last_chunk(SQLite::Database& database) {
    return database.execAndGet("SELECT coalesce(max(id), 0) FROM chunk").getInt64();
}

Result<std::vector<HistorySample>> read_samples(SQLite::Database& database, const ChunkRow& row) {
    const Chunk chunk = read_chunk(database, row.id);
    auto samples = chunk.samples();
    const auto& summary = row.summary;
    if (!samples || (chunk.is_bound() && std::cmp_not_equal(chunk.series, row.series.value)) ||
        samples->size() != summary.samples || samples->front().time_ns != summary.begin_ns ||
        samples->back().time_ns != summary.end_ns)
        return fail(Code::malformed);
    return *std::move(samples);
}

HistoryDamage damage_of(const ChunkRow& row, const std::string& variable) {
    return {.part = HistoryPart::chunk,
            .row = row.id,
            .variable = variable,
            .first_ns = row.summary.begin_ns,
            .last_ns = row.summary.end_ns,
            .samples = row.summary.samples};
}

std::size_t drop_chunks(SQLite::Database& database, HistoryState& state, std::int64_t cutoff_ns,
                        std::size_t most) {
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
    writer.finish(state);
    return chunks.size();
}

void rebuild_rollups(SQLite::Database& database, const std::vector<SeriesRow>& all, const HistoryGaps& gaps) {
    const auto sql =
        database.execAndGet("SELECT sql FROM sqlite_master WHERE type = 'table' AND name = 'rollup'")
            .getString();
    database.exec("CREATE TABLE rebuilt " + sql.substr(std::min(sql.find('('), sql.size())));
    {
        SQLite::Statement insert(database, insert_row("rebuilt"));
        for (const SeriesRow& series : all)
            for (const ChunkRow& row : read_chunks(database, series, gaps).rows)
                static_cast<void>(write_row(insert, row));
    }
    database.exec(
        "DROP TABLE rollup; ALTER TABLE rebuilt RENAME TO rollup;"
        "CREATE INDEX rollup_by_end ON rollup (t1);"
        "CREATE INDEX rollup_open ON rollup (open) WHERE open = 1");
}

// One variable after the other: their rows are in memory.
void add_sums(SQLite::Database& database) {
    std::vector<std::int64_t> all;
    {
        SQLite::Statement select(database, "SELECT DISTINCT series FROM rollup");
        while (select.executeStep()) all.push_back(select.getColumn(0).getInt64());
    }
    SQLite::Statement update(database, "UPDATE rollup SET sum = ? WHERE series = ? AND t0 = ? AND chunk = ?");
    for (const std::int64_t series : all) {
        SQLite::Statement select(database,
                                 std::string("SELECT ") + kRowColumns + " FROM rollup WHERE series = ?");
        select.bind(1, series);
        std::vector<ChunkRow> rows;
        while (select.executeStep()) rows.push_back(chunk_row(select));
        for (const ChunkRow& row : rows) {
            update.bind(1, sum_of(row));
            update.bind(2, series);
            update.bind(3, milliseconds(row.summary.begin_ns));
            update.bind(4, row.id);
            update.exec();
            update.reset();
        }
    }
    add_gap_sums(database);
}

void count_rows(SQLite::Database& database, HistoryState& state, const std::set<SeriesId>& incomplete) {
    const auto digest = [&database](const std::string& rows) {
        SQLite::Statement select(database, "SELECT count(*), coalesce(sum(sum), 0) FROM " + rows);
        select.executeStep();
        return RowsDigest{select.getColumn(0).getInt64(), select.getColumn(1).getInt64()};
    };
    state.gaps = digest("gap NOT INDEXED");
    state.log = digest_of_log(database);
    for (SeriesRow& row : read_series_rows(database)) {
        if (!row.is_good() || incomplete.contains(row.info.id)) continue;
        row.chunks = digest("rollup WHERE series = " + std::to_string(row.info.id.value));
        write_series_row(database, state, row);
    }
    state.series = digest("series NOT INDEXED");
}

}  // namespace takt::store
