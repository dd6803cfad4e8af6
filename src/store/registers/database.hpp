// SQLite through SQLiteCpp. Its exceptions end here: callers outside this module get Results.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <type_traits>

#include "takt/base/result.hpp"

namespace takt::store {

/// A database file begins with it.
inline constexpr std::string_view kDatabaseMark("SQLite format 3\0", 16);

/// How long a statement waits for the lock of another program, in ms.
inline constexpr int kLockWaitMs = 500;

[[nodiscard]] bool file_exists(const std::string& path);

/// Opens a database; it is created unless `read_only`.
/// @throws SQLite::Exception
[[nodiscard]] SQLite::Database open_database(const std::string& path, bool read_only);

/// The error of a failed call: busy, malformed (damaged, or not a database), cannot_open, io_failed.
/// @param database  where it is open, for the system's error number; nullptr: the number is a guess
[[nodiscard]] Error error_of(const std::string& path, const SQLite::Exception& exception,
                             const SQLite::Database* database);

/// @returns replaced: the file that is open is no longer the one of that path
[[nodiscard]] Result<void> check_unmoved(const SQLite::Database& database, const std::string& path);

/// Fingerprint of a database file between two transactions. A program that writes into the file in place
/// (truncation, zeros, an older copy) changes it.
struct FileContents {
    std::int64_t size = 0;
    std::uint32_t checksum = 0;  ///< CRC-32C of the whole file
    friend bool operator==(const FileContents&, const FileContents&) = default;
};

/// Reads through SQLite's own descriptor: closing another one would release the locks of the process.
/// @returns io_failed
[[nodiscard]] Result<FileContents> contents_of(const SQLite::Database& database, const std::string& path);

/// Calls `function`, which returns a Result and may throw SQLite::Exception.
template <class Function>
[[nodiscard]] std::invoke_result_t<Function> with_results(const std::string& path,
                                                          const SQLite::Database* database,
                                                          Function function) {
    try {
        return function();
    } catch (const SQLite::Exception& exception) {
        return std::unexpected(error_of(path, exception, database));
    }
}

/// Calls `step` until it returns false. @returns false: a damaged page ended the query
template <class Step>
bool unless_damaged(Step step) {
    try {
        while (step()) {}
        return true;
    } catch (const SQLite::Exception& exception) {
        if ((exception.getErrorCode() & 0xFF) != SQLITE_CORRUPT) throw;
        return false;
    }
}

}  // namespace takt::store
