// SQLite schema: one row for each value with its name, its type as in project files ("scaled " before the
// type if values are doubles), value and wanted value as text that parses to the same value, and a checksum
// of these columns (FNV-1a, 64 bits). SQLite has no checksums; the column detects a value that the medium
// corrupted.
#include "registers/retained_rows.hpp"

#include <optional>
#include <string_view>
#include <utility>

#include "takt/value/text.hpp"

namespace takt::store {
namespace {

constexpr std::int64_t kRetainedApplication = 0x54616B74;  // "Takt"
constexpr std::int64_t kRetainedVersion = 1;
constexpr std::string_view kScaled = "scaled ";

struct RetainedRow {
    std::string name;
    std::string type;
    std::optional<std::string> value;
    std::optional<std::string> wanted;

    [[nodiscard]] std::int64_t checksum() const {
        std::uint64_t sum = 0xCBF29CE484222325;
        const auto add = [&sum](std::uint8_t byte) { sum = (sum ^ byte) * 0x100000001B3; };
        const auto add_text = [&add](std::string_view text) {
            for (const char c : text) add(static_cast<std::uint8_t>(c));
            add(0xFF);  // in no UTF-8 text: another column follows
        };
        add_text(name);
        add_text(type);
        for (const auto& text : {value, wanted}) {
            add(text ? 1 : 0);
            add_text(text.value_or(""));
        }
        return static_cast<std::int64_t>(sum);
    }
};

std::optional<std::string> as_text(const Retained& entry, const value::Value& value) {
    if (value::is_empty(value)) return std::nullopt;
    return value::format(entry.type, entry.scaled, value);
}

RetainedRow row_of(const Retained& entry) {
    return {entry.name, std::string(entry.scaled ? kScaled : "").append(name(entry.type)),
            as_text(entry, entry.value), as_text(entry, entry.wanted)};
}

Result<value::Value> parsed(const Retained& entry, const std::optional<std::string>& text) {
    if (!text) return Result<value::Value>(std::in_place);
    return value::parse(entry.type, entry.scaled, *text);
}

Result<Retained> entry_of(const RetainedRow& row) {
    Retained entry{.name = row.name, .scaled = row.type.starts_with(kScaled)};
    const auto type = data_type(std::string_view(row.type).substr(entry.scaled ? kScaled.size() : 0));
    if (!type) return fail(Code::malformed);
    entry.type = *type;
    TAKT_TRY(entry.value, parsed(entry, row.value));
    TAKT_TRY(entry.wanted, parsed(entry, row.wanted));
    return entry;
}

std::optional<std::string> optional_text(const SQLite::Column& column) {
    if (column.isNull()) return std::nullopt;
    return column.getString();
}

void bind(SQLite::Statement& statement, int parameter, const std::optional<std::string>& text) {
    if (text)
        statement.bind(parameter, *text);
    else
        statement.bind(parameter);
}

void replace_row(SQLite::Statement& insert, const RetainedRow& row) {
    insert.bind(1, row.name);
    insert.bind(2, row.type);
    bind(insert, 3, row.value);
    bind(insert, 4, row.wanted);
    insert.bind(5, row.checksum());
    insert.exec();
    insert.reset();
}

}  // namespace

void make_tables(SQLite::Database& database) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    database.exec(
        "CREATE TABLE retained (name TEXT PRIMARY KEY NOT NULL, type TEXT NOT NULL, value TEXT, wanted TEXT,"
        " checksum INTEGER NOT NULL) WITHOUT ROWID;"
        "CREATE TABLE extent (rows INTEGER NOT NULL);"
        "INSERT INTO extent VALUES (0);"
        "PRAGMA application_id = " +
        std::to_string(kRetainedApplication) + ";PRAGMA user_version = " + std::to_string(kRetainedVersion));
    transaction.commit();
}

Result<std::vector<Retained>> read_rows(SQLite::Database& database, const std::string& path) {
    const auto damaged = [&path] { return fail(Code::malformed, path); };
    const std::string sound = database.execAndGet("PRAGMA integrity_check(1)").getString();
    const std::int64_t application = database.execAndGet("PRAGMA application_id").getInt64();
    const std::int64_t version = database.execAndGet("PRAGMA user_version").getInt64();
    if (sound != "ok" || application != kRetainedApplication) return damaged();
    if (version > kRetainedVersion) return fail(Code::unsupported, path);
    if (version < 1) return damaged();
    SQLite::Statement extent(database, "SELECT rows FROM extent");
    if (!extent.executeStep()) return damaged();
    SQLite::Statement select(database,
                             "SELECT name, type, value, wanted, checksum FROM retained ORDER BY name");
    std::vector<Retained> entries;
    while (select.executeStep()) {
        const RetainedRow row{select.getColumn(0).getString(), select.getColumn(1).getString(),
                              optional_text(select.getColumn(2)), optional_text(select.getColumn(3))};
        const auto entry = entry_of(row);
        if (row.checksum() != select.getColumn(4).getInt64() || !entry) return damaged();
        entries.push_back(*entry);
    }
    if (std::cmp_not_equal(entries.size(), extent.getColumn(0).getInt64())) return damaged();
    return entries;
}

void write_rows(SQLite::Database& database, const std::map<std::string, Retained>& entries) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement insert(database, "INSERT OR REPLACE INTO retained VALUES (?, ?, ?, ?, ?)");
    for (const auto& [name, entry] : entries) replace_row(insert, row_of(entry));
    // The number of rows: a lost row is damage, too.
    database.exec("UPDATE extent SET rows = (SELECT count(*) FROM retained)");
    transaction.commit();
}

}  // namespace takt::store
