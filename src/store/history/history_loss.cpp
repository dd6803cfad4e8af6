#include "history/history_loss.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "history/history_chunks.hpp"
#include "history/history_schema.hpp"
#include "history/history_tables.hpp"

namespace takt::store {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

/// The last change of the file or its write-ahead log; 0: unknown.
std::int64_t changed_ns(const std::string& path) {
    std::int64_t newest = 0;
    for (const auto& name : {path, path + "-wal"}) {
        struct stat its{};
        if (::stat(name.c_str(), &its) != 0) continue;
        newest = std::max(newest, std::int64_t{its.st_mtim.tv_sec} * kNsPerSecond + its.st_mtim.tv_nsec);
    }
    return newest;
}

/// The times of the samples, as far as they can be read.
struct Extent {
    std::optional<std::int64_t> first_ns;
    std::optional<std::int64_t> last_ns;
    bool complete = false;  ///< nothing is damaged that could have other times

    void include(std::int64_t first, std::int64_t last) {
        first_ns = std::min(first_ns.value_or(first), first);
        last_ns = std::max(last_ns.value_or(last), last);
    }
};

Result<void> read_extent(SQLite::Database& database, const std::string& path, Extent& extent) {
    TAKT_CHECK(check_history(database, path));
    view_history(database);
    const auto state = read_state(database);
    const bool chunks = each_chunk(
        database, [&](const ChunkRow& row) { extent.include(row.summary.begin_ns, row.summary.end_ns); });
    const auto log = read_log(database, state, std::nullopt);
    for (const auto& logged : log.samples) extent.include(logged.sample.time_ns, logged.sample.time_ns);
    if (extent.first_ns && !state.damaged) extent.include(*extent.first_ns, state.known_until_ns);
    extent.complete = chunks && log.damage.empty() && !state.damaged;
    return {};
}

bool has_tables(SQLite::Database& database) {
    return database.execAndGet("SELECT count(*) FROM sqlite_master").getInt() > 0;
}

// A program that was killed while it began the file leaves one without tables. Nothing is lost then.
std::optional<HistoryGap> loss_of(const std::string& path, Duration retention) {
    Extent extent;
    const auto read = with_results(path, nullptr, [&]() -> Result<void> {
        SQLite::Database database(path, SQLite::OPEN_READONLY | SQLite::OPEN_NOMUTEX, kLockWaitMs);
        extent.complete = !has_tables(database);
        return extent.complete ? Result<void>() : read_extent(database, path, extent);
    });
    HistoryGap gap{.cause = GapCause::damaged};
    if (read && extent.complete) {
        if (!extent.first_ns) return std::nullopt;
        gap.first_ns = *extent.first_ns;
        gap.last_ns = *extent.last_ns;
        return gap;
    }
    const std::int64_t changed = changed_ns(path);
    const std::int64_t oldest = retention > Duration::zero() ? changed - retention.count() : 0;
    gap.first_ns = std::min(extent.first_ns.value_or(oldest), oldest);
    gap.last_ns = std::max(extent.last_ns.value_or(changed), changed);
    return gap;
}

Result<HistoryFile> begun_with(const std::optional<HistoryGap>& gap, const std::string& path) {
    TAKT_TRY(HistoryFile file, open_history_file(path));
    if (!gap) return file;
    TAKT_CHECK(with_results(path, file.database.get(), [&]() -> Result<void> {
        SQLite::Transaction transaction(*file.database, SQLite::TransactionBehavior::IMMEDIATE);
        auto state = read_state(*file.database);
        write_gap(*file.database, state, *gap);
        write_state(*file.database, state);
        transaction.commit();
        return {};
    }));
    return file;
}

void move_back(const std::string& aside, const std::string& path) {
    std::error_code error;
    std::filesystem::remove(path + "-wal", error);
    std::filesystem::rename(aside, path, error);
    std::filesystem::rename(aside + "-wal", path + "-wal", error);
}

}  // namespace

Result<ReplacedHistory> replace_history(const std::string& path, Duration retention) {
    const auto gap = loss_of(path, retention);
    TAKT_TRY(auto aside, set_history_aside(path));
    auto file = begun_with(gap, path);
    if (!file) {
        move_back(aside, path);
        return std::unexpected(file.error());
    }
    return ReplacedHistory{*std::move(file), std::move(aside)};
}

}  // namespace takt::store
