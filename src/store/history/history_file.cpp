#include "history/history_file.hpp"

#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "history/history_schema.hpp"
#include "takt/os/open.hpp"
#include "takt/os/set_aside.hpp"

namespace takt::store {
namespace {

constexpr std::size_t kPageBytes = 4096;  // of SQLite by default

// FULL: each commit synchronises the write-ahead log. With NORMAL a power cut could undo commits whose
// samples that the journal has already dropped. Freed pages are used again; the file does not shrink.
constexpr const char* kHistorySettings =
    "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA cell_size_check = ON;"
    "PRAGMA journal_size_limit = 67108864";

/// Whether the bytes are a leaf page of a table with cells: https://www.sqlite.org/fileformat.html, 1.6.
bool is_table_page(std::span<const std::uint8_t> page) {
    constexpr std::uint8_t kTableLeaf = 0x0D;
    constexpr std::size_t kHeader = 8;
    const auto number_at = [&](std::size_t at) { return std::size_t{page[at]} << 8U | page[at + 1]; };
    if (page[0] != kTableLeaf) return false;
    const auto cells = number_at(3);
    const auto content = number_at(5);
    if (cells == 0 || content < kHeader + 2 * cells || content >= page.size()) return false;
    for (std::size_t i = 0; i < cells; ++i)
        if (const auto cell = number_at(kHeader + 2 * i); cell < content || cell >= page.size()) return false;
    return true;
}

/// Whether a page after the first one shows that the file was a database.
bool has_table_page(const os::Descriptor& file) {
    constexpr off_t kMostPages = 256;
    std::array<std::uint8_t, kPageBytes> page{};
    for (off_t i = 1; i < kMostPages; ++i) {
        const auto count = ::pread(file.get(), page.data(), page.size(), i * static_cast<off_t>(page.size()));
        if (count != static_cast<ssize_t>(page.size())) return false;
        if (is_table_page(page)) return true;
    }
    return false;
}

/// A file of another program must not be touched. A database whose first page is damaged is no such file.
/// @returns malformed (cut off or empty), unsupported
Result<void> check_database_mark(const os::Descriptor& file, const std::string& path) {
    std::array<char, kDatabaseMark.size()> head{};
    const auto count = ::pread(file.get(), head.data(), head.size(), 0);
    const std::string_view there(head.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
    const bool zeros = there.find_first_not_of('\0') == std::string_view::npos;
    if (there == kDatabaseMark) return {};
    const bool ours = zeros || kDatabaseMark.starts_with(there) || has_table_page(file);
    return fail(ours ? Code::malformed : Code::unsupported, path);
}

Result<os::Descriptor> locked(Result<os::Descriptor> file, const std::string& path) {
    if (!file) return file;
    if (::flock(file->get(), LOCK_EX | LOCK_NB) != 0) return fail(Code::busy, path);
    return file;
}

}  // namespace

Result<void> check_history_mark(const std::string& path) {
    TAKT_TRY(const auto file, os::open_for_reading(path));
    return check_database_mark(file, path);
}

Result<HistoryFile> open_history_file(const std::string& path) {
    HistoryFile opened;
    const bool is_new = !file_exists(path);
    TAKT_TRY(opened.lock, locked(is_new ? os::create_file(path) : os::open_for_update(path), path));
    // Closing a descriptor of the file would release SQLite's locks, so this one stays open.
    if (!is_new) TAKT_CHECK(check_database_mark(opened.lock, path));
    TAKT_CHECK(with_results(path, nullptr, [&]() -> Result<void> {
        opened.database = std::make_unique<SQLite::Database>(open_database(path, false));
        return {};
    }));
    TAKT_CHECK(with_results(path, opened.database.get(), [&]() -> Result<void> {
        // A power cut can leave the file without its tables.
        const bool empty = is_new || is_empty_history(*opened.database);
        if (!empty)
            if (auto ours = check_history(*opened.database, path); !ours) return ours;
        opened.database->exec(kHistorySettings);
        if (empty)
            make_history_tables(*opened.database);
        else
            upgrade_history(*opened.database);
        return {};
    }));
    return opened;
}

Result<std::string> set_history_aside(const std::string& path) {
    TAKT_TRY(auto aside, os::set_aside(path, "-wal"));
    std::error_code error;
    std::filesystem::remove(path + "-shm", error);
    return aside;
}

}  // namespace takt::store
