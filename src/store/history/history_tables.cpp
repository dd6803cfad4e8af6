// Reads of rows do not use indexes: a damaged index would hide rows. Behind a damaged page a query has no
// more rows; the digests show that they are missing.
#include "history/history_tables.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace takt::store {
namespace {

constexpr const char* kSeriesRows =
    "SELECT id, name, device, type, scaled, unit, chunks, chunk_sum, sum FROM series";

/// A number that may be absent.
void add_optional(RowSum& sum, std::optional<std::int64_t> value) {
    sum.add(std::int64_t{value.has_value()}).add(value.value_or(0));
}

std::int64_t sum_of(const HistoryState& state) {
    RowSum sum('s');
    const auto& position = state.position;
    add_optional(sum, position ? std::optional(static_cast<std::int64_t>(position->journal)) : std::nullopt);
    add_optional(sum, position ? std::optional(static_cast<std::int64_t>(position->sequence)) : std::nullopt);
    const bool is_known = state.known_until_ns != INT64_MIN;
    add_optional(sum, is_known ? std::optional(milliseconds(state.known_until_ns)) : std::nullopt);
    for (const auto* const digest : {&state.log, &state.gaps, &state.series})
        sum.add(digest->rows).add(digest->sum);
    return sum.value();
}

std::int64_t sum_of(const SeriesRow& row) {
    RowSum sum('v');
    sum.add(std::int64_t{row.info.id.value}).add(row.info.series.name).add(row.info.series.device);
    sum.add(row.type).add(std::int64_t{row.info.series.scaled}).add(row.info.series.unit);
    return sum.add(row.chunks.rows).add(row.chunks.sum).value();
}

std::int64_t sum_of(const HistoryGap& gap) {
    return RowSum('g')
        .add(milliseconds(gap.first_ns))
        .add(milliseconds(gap.last_ns))
        .add(static_cast<std::int64_t>(gap.cause))
        .add(static_cast<std::int64_t>(gap.samples))
        .value();
}

RowsDigest digest_at(SQLite::Statement& row, int column) {
    return {row.getColumn(column).getInt64(), row.getColumn(column + 1).getInt64()};
}

SeriesRow series_row(SQLite::Statement& row) {
    SeriesRow series;
    series.info.id = SeriesId{row.getColumn(0).getUInt()};
    auto& properties = series.info.series;
    properties.name = row.getColumn(1).getString();
    properties.device = row.getColumn(2).getString();
    series.type = row.getColumn(3).getString();
    properties.type = data_type(series.type).value_or(DataType::float64);
    properties.scaled = row.getColumn(4).getInt() != 0;
    properties.unit = row.getColumn(5).getString();
    series.chunks = digest_at(row, 6);
    series.sum = row.getColumn(8).getInt64();
    return series;
}

using SeriesNames = std::map<std::int64_t, std::string>;  // by number

/// As the index of the names has them.
SeriesNames indexed_names(SQLite::Database& database) {
    SeriesNames names;
    std::optional<SQLite::Statement> select;
    // In a file of version 1 the view has no index.
    unless_damaged([&] {
        if (!select)
            select.emplace(database, "SELECT id, name FROM main.series INDEXED BY sqlite_autoindex_series_1");
        if (!select->executeStep()) return false;
        names.emplace(select->getColumn(0).getInt64(), select->getColumn(1).getString());
        return true;
    });
    return names;
}

/// Gives a damaged row the name of the index, if its sum shows that nothing else is damaged.
bool restore_name(SeriesRow& row, const SeriesNames& names) {
    const auto indexed = names.find(row.info.id.value);
    if (indexed == names.end() || row.is_good()) return false;
    SeriesRow other = row;
    other.info.series.name = indexed->second;
    if (!other.is_good()) return false;
    row = std::move(other);
    return true;
}

/// The variables that the index has and no good row. Where the damaged row of the same number has another
/// name, either may be wrong, and the name is unknown.
std::vector<HistoryDamage> lost_series(const SeriesNames& names, const std::vector<SeriesRow>& good,
                                       const SeriesNames& bad) {
    std::vector<HistoryDamage> lost;
    for (const auto& [id, name] : names) {
        const bool found = std::ranges::any_of(good, [&](const SeriesRow& row) {
            return row.info.id.value == id || row.info.series.name == name;
        });
        if (found) continue;
        const auto stored = bad.find(id);
        const bool is_certain = stored == bad.end() || stored->second == name;
        lost.push_back({.part = HistoryPart::series, .row = id, .variable = is_certain ? name : ""});
    }
    return lost;
}

/// A row of gaps as it is in the file.
struct StoredGap {
    std::int64_t id = 0;
    HistoryGap gap;
    std::int64_t sum = kNoSum;

    [[nodiscard]] bool is_good() const { return sum == kNoSum || sum == sum_of(gap); }
};

std::vector<StoredGap> stored_gaps(SQLite::Database& database) {
    SQLite::Statement select(database, "SELECT id, first, last, cause, samples, sum FROM gap NOT INDEXED");
    std::vector<StoredGap> all;
    unless_damaged([&] {
        if (!select.executeStep()) return false;
        all.push_back(
            {select.getColumn(0).getInt64(),
             {nanoseconds(select.getColumn(1).getInt64()), nanoseconds(select.getColumn(2).getInt64()),
              static_cast<GapCause>(select.getColumn(3).getInt()),
              static_cast<std::uint64_t>(select.getColumn(4).getInt64())},
             select.getColumn(5).getInt64()});
        return true;
    });
    return all;
}

/// The checksum that ends a row of the log.
std::int64_t log_sum(Bytes row) {
    if (row.size() < kCrc32cBytes) return 0;
    return LittleEndianReader(row.last(kCrc32cBytes)).take<std::uint32_t>();
}

std::vector<LogRow> stored_log(SQLite::Database& database) {
    SQLite::Statement select(database, "SELECT id, data FROM log");
    std::vector<LogRow> rows;
    unless_damaged([&] {
        if (!select.executeStep()) return false;
        rows.push_back({select.getColumn(0).getInt64(), bytes_of(select.getColumn(1))});
        return true;
    });
    return rows;
}

/// The rows 1 to `count`. A missing one is empty, and so is one whose number is none of them or not the next.
std::vector<LogRow> numbered(std::vector<LogRow> stored, std::int64_t count) {
    std::vector<LogRow> rows;
    std::int64_t next = 1;
    for (LogRow& row : stored) {
        if (row.id < next || row.id > count) row.data.clear();
        for (; next < std::min(row.id, count + 1); ++next) rows.push_back({next, {}});
        if (row.id == next) ++next;
        rows.push_back(std::move(row));
    }
    for (; next <= count; ++next) rows.push_back({next, {}});
    return rows;
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

std::vector<std::uint8_t> bytes_of(const SQLite::Column& column) {
    const auto* const data = static_cast<const std::uint8_t*>(column.getBlob());
    const auto size = static_cast<std::size_t>(column.getBytes());
    return data == nullptr ? std::vector<std::uint8_t>() : std::vector<std::uint8_t>(data, data + size);
}

void bind_bytes(SQLite::Statement& statement, int index, const std::vector<std::uint8_t>& bytes) {
    statement.bindNoCopy(index, bytes.data(), static_cast<int>(bytes.size()));
}

HistoryState read_state_of_version_1(SQLite::Database& database) {
    HistoryState state{.log = kUnknownDigest, .gaps = kUnknownDigest, .series = kUnknownDigest};
    SQLite::Statement select(database, "SELECT journal, sequence, known_until FROM state");
    if (!select.executeStep()) return state;
    if (!select.isColumnNull(0))
        state.position = HistoryPosition{static_cast<std::uint64_t>(select.getColumn(0).getInt64()),
                                         static_cast<std::uint64_t>(select.getColumn(1).getInt64())};
    if (!select.isColumnNull(2)) state.known_until_ns = nanoseconds(select.getColumn(2).getInt64());
    return state;
}

HistoryState read_state(SQLite::Database& database) {
    HistoryState state = read_state_of_version_1(database);
    SQLite::Statement select(
        database, "SELECT log_rows, log_sum, gaps, gap_sum, all_series, series_sum, sum FROM state");
    if (select.executeStep()) {
        state.log = digest_at(select, 0);
        state.gaps = digest_at(select, 2);
        state.series = digest_at(select, 4);
        const std::int64_t sum = select.getColumn(6).getInt64();
        if (sum == kNoSum || sum == sum_of(state)) return state;
    }
    return {.log = kUnknownDigest, .gaps = kUnknownDigest, .series = kUnknownDigest, .damaged = true};
}

void write_state(SQLite::Database& database, const HistoryState& state) {
    SQLite::Statement update(database,
                             "INSERT OR REPLACE INTO state (id, journal, sequence, known_until, log_rows,"
                             " log_sum, gaps, gap_sum, all_series, series_sum, sum)"
                             " VALUES (1, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    if (state.position) {
        update.bind(1, static_cast<std::int64_t>(state.position->journal));
        update.bind(2, static_cast<std::int64_t>(state.position->sequence));
    }
    if (state.known_until_ns != INT64_MIN) update.bind(3, milliseconds(state.known_until_ns));
    int index = 4;
    for (const auto* const digest : {&state.log, &state.gaps, &state.series}) {
        update.bind(index++, digest->rows);
        update.bind(index++, digest->sum);
    }
    update.bind(index, sum_of(state));
    update.exec();
}

bool SeriesRow::is_good() const {
    return sum == kNoSum || sum == sum_of(*this);
}

std::vector<SeriesRow> read_series_rows(SQLite::Database& database) {
    SQLite::Statement select(database, std::string(kSeriesRows) + " NOT INDEXED");
    std::vector<SeriesRow> all;
    while (select.executeStep()) all.push_back(series_row(select));
    std::ranges::sort(all, {}, [](const SeriesRow& row) -> const auto& { return row.info.series.name; });
    return all;
}

std::optional<SeriesRow> read_series_row(SQLite::Database& database, SeriesId id) {
    SQLite::Statement select(database, std::string(kSeriesRows) + " WHERE id = ?");
    select.bind(1, id.value);
    return select.executeStep() ? std::optional(series_row(select)) : std::nullopt;
}

void write_series_row(SQLite::Database& database, HistoryState& state, const SeriesRow& row) {
    const auto& [id, series] = row.info;
    SeriesRow next = row;
    next.type = name(series.type);
    next.sum = sum_of(next);
    SQLite::Statement update(database,
                             "UPDATE series SET device = ?, type = ?, scaled = ?, unit = ?, chunks = ?,"
                             " chunk_sum = ?, sum = ? WHERE id = ?");
    update.bind(1, series.device);
    update.bind(2, next.type);
    update.bind(3, series.scaled ? 1 : 0);
    update.bind(4, series.unit);
    update.bind(5, next.chunks.rows);
    update.bind(6, next.chunks.sum);
    update.bind(7, next.sum);
    update.bind(8, id.value);
    update.exec();
    state.series.sum += next.sum - row.sum;
}

SeriesId write_series(SQLite::Database& database, HistoryState& state, const HistorySeries& series) {
    std::optional<SeriesRow> row;
    {
        SQLite::Statement select(database, std::string(kSeriesRows) + " WHERE name = ?");
        select.bind(1, series.name);
        if (select.executeStep()) row = series_row(select);
    }
    if (!row) {
        SQLite::Statement insert(
            database,
            "INSERT INTO series (name, device, type, scaled, unit, chunks, chunk_sum, sum)"
            " VALUES (?, '', '', 0, '', 0, 0, 0) RETURNING id");
        insert.bind(1, series.name);
        insert.executeStep();
        row = SeriesRow{.info = {.id = SeriesId{insert.getColumn(0).getUInt()}}, .sum = 0};
        ++state.series.rows;
    } else if (!row->is_good()) {
        SQLite::Statement count(database,
                                "SELECT count(*), coalesce(sum(sum), 0) FROM rollup WHERE series = ?");
        count.bind(1, row->info.id.value);
        if (count.executeStep()) row->chunks = digest_at(count, 0);
    }
    row->info.series = series;
    write_series_row(database, state, *row);
    return row->info.id;
}

std::vector<HistoryDamage> damage_of(const std::vector<SeriesRow>& rows, const HistoryState& state) {
    std::vector<HistoryDamage> damage;
    RowsDigest digest;
    for (const SeriesRow& row : rows) {
        digest.add(row.sum);
        if (!row.is_good()) damage.push_back({.part = HistoryPart::series, .row = row.info.id.value});
    }
    if (damage.empty() && state.series.is_known() && digest != state.series)
        damage.push_back({.part = HistoryPart::series});
    return damage;
}

ReadSeries read_series(SQLite::Database& database, const HistoryState& state) {
    std::vector<SeriesRow> all;
    SQLite::Statement select(database, std::string(kSeriesRows) + " NOT INDEXED");
    const bool complete = unless_damaged([&] {
        if (!select.executeStep()) return false;
        all.push_back(series_row(select));
        return true;
    });
    ReadSeries read{.damage = damage_of(all, state)};
    if (!complete && read.damage.empty()) read.damage.push_back({.part = HistoryPart::series});
    const auto names = read.damage.empty() ? SeriesNames() : indexed_names(database);
    SeriesNames bad;
    bool restored = false;
    for (SeriesRow& row : all) {
        restored = restore_name(row, names) || restored;
        if (row.is_good())
            read.rows.push_back(std::move(row));
        else
            bad.emplace(row.info.id.value, row.info.series.name);
    }
    std::ranges::sort(read.rows, {},
                      [](const SeriesRow& row) -> const auto& { return row.info.series.name; });
    const auto lost = lost_series(names, read.rows, bad);
    // Other damaged rows are remains of these, if they are as many as the state counts.
    const auto missing = state.series.rows - static_cast<std::int64_t>(read.rows.size());
    const bool all_lost = state.series.is_known() && std::cmp_equal(missing, lost.size());
    std::erase_if(read.damage, [&](const HistoryDamage& its) {
        if (all_lost && (restored || missing > 0)) return true;
        return its.row > 0 && std::ranges::count(lost, its.row, &HistoryDamage::row) > 0;
    });
    read.damage.insert(read.damage.end(), lost.begin(), lost.end());
    return read;
}

bool restore_names(SQLite::Database& database, std::vector<SeriesRow>& rows) {
    const auto names = indexed_names(database);
    bool restored = false;
    for (SeriesRow& row : rows) restored = restore_name(row, names) || restored;
    return restored;
}

// With a writable schema an update does not require that the index has the damaged name.
void repair_series(SQLite::Database& database, const std::vector<SeriesRow>& rows) {
    database.exec("PRAGMA writable_schema = ON");
    SQLite::Statement update(database, "UPDATE series SET name = ?1 WHERE id = ?2 AND name <> ?1");
    for (const SeriesRow& row : rows) {
        update.bind(1, row.info.series.name);
        update.bind(2, row.info.id.value);
        update.exec();
        update.reset();
    }
    database.exec("PRAGMA writable_schema = OFF");
    database.exec("REINDEX series");
}

void write_gap(SQLite::Database& database, HistoryState& state, const HistoryGap& gap) {
    SQLite::Statement insert(database,
                             "INSERT INTO gap (first, last, cause, samples, sum) VALUES (?, ?, ?, ?, ?)");
    const std::int64_t sum = sum_of(gap);
    insert.bind(1, milliseconds(gap.first_ns));
    insert.bind(2, milliseconds(gap.last_ns));
    insert.bind(3, static_cast<int>(gap.cause));
    insert.bind(4, static_cast<std::int64_t>(gap.samples));
    insert.bind(5, sum);
    insert.exec();
    state.gaps.add(sum);
}

ReadGaps read_gaps(SQLite::Database& database, const HistoryState& state) {
    ReadGaps read;
    RowsDigest digest;
    for (const auto& stored : stored_gaps(database)) {
        digest.add(stored.sum);
        if (stored.is_good())
            read.gaps.push_back(stored.gap);
        else
            read.damage.push_back({.part = HistoryPart::gap, .row = stored.id});
    }
    if (read.damage.empty() && state.gaps.is_known() && digest != state.gaps)
        read.damage.push_back({.part = HistoryPart::gap});
    std::ranges::stable_sort(read.gaps, {}, &HistoryGap::first_ns);
    return read;
}

HistoryGaps gaps_in(const HistoryGaps& gaps, std::int64_t from_ns, std::int64_t to_ns) {
    HistoryGaps found;
    for (const auto& gap : gaps)
        if (milliseconds(gap.last_ns) >= milliseconds(from_ns) &&
            milliseconds(gap.first_ns) <= milliseconds(to_ns))
            found.push_back(gap);
    return found;
}

void drop_gaps(SQLite::Database& database, HistoryState& state, std::int64_t cutoff_ns) {
    SQLite::Statement erase(database, "DELETE FROM gap WHERE last < ? RETURNING sum");
    erase.bind(1, milliseconds(cutoff_ns));
    while (erase.executeStep()) state.gaps.remove(erase.getColumn(0).getInt64());
}

// An index may not fit its damaged table, and SQLite would then refuse to delete a row.
void repair_gaps(SQLite::Database& database) {
    database.exec("DROP INDEX gap_by_end");
    SQLite::Statement erase(database, "DELETE FROM gap WHERE id = ?");
    for (const auto& stored : stored_gaps(database)) {
        if (stored.is_good()) continue;
        erase.bind(1, stored.id);
        erase.exec();
        erase.reset();
    }
    database.exec("CREATE INDEX gap_by_end ON gap (last)");
}

void add_gap_sums(SQLite::Database& database) {
    SQLite::Statement update(database, "UPDATE gap SET sum = ? WHERE id = ?");
    for (const auto& stored : stored_gaps(database)) {
        update.bind(1, sum_of(stored.gap));
        update.bind(2, stored.id);
        update.exec();
        update.reset();
    }
}

void write_log(SQLite::Database& database, HistoryState& state, const std::vector<std::uint8_t>& row) {
    SQLite::Statement insert(database, "INSERT INTO log (id, data) VALUES (?, ?)");
    insert.bind(1, state.log.rows + 1);
    bind_bytes(insert, 2, row);
    insert.exec();
    state.log.add(log_sum(row));
}

// The log is newer than the chunks that are closed, and older than the last commit.
DecodedLog read_log(SQLite::Database& database, const HistoryState& state,
                    std::optional<std::int64_t> from_ns) {
    auto rows = stored_log(database);
    if (state.log.is_known()) rows = numbered(std::move(rows), state.log.rows);
    const std::int64_t first = from_ns.value_or(state.known_until_ns);
    auto log = decode_log(rows, first, std::max(first, state.known_until_ns));
    for (auto& damage : log.damage)
        if (damage.first_ns == INT64_MIN) damage.first_ns = damage.last_ns = std::nullopt;
    RowsDigest digest;
    for (const LogRow& row : rows) digest.add(log_sum(row.data));
    // Sound rows, but others than were written.
    if (log.damage.empty() && state.log.is_known() && digest != state.log) {
        log.samples.clear();
        log.damage.push_back({.part = HistoryPart::log});
    }
    return log;
}

std::optional<std::int64_t> newest_chunk_end(SQLite::Database& database) {
    std::optional<std::int64_t> end;
    unless_damaged([&] {
        SQLite::Statement select(database, "SELECT max(t1) FROM rollup");
        if (select.executeStep() && !select.isColumnNull(0))
            end = nanoseconds(select.getColumn(0).getInt64());
        return false;
    });
    return end;
}

RowsDigest digest_of_log(SQLite::Database& database) {
    RowsDigest digest;
    for (const LogRow& row : stored_log(database)) digest.add(log_sum(row.data));
    return digest;
}

void clear_log(SQLite::Database& database, HistoryState& state) {
    database.exec("DELETE FROM log");
    state.log = {};
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
