#include "registers/database.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <vector>

#include "takt/store/crc32c.hpp"

namespace takt::store {
bool file_exists(const std::string& path) {
    std::error_code error;
    return std::filesystem::exists(path, error);
}

SQLite::Database open_database(const std::string& path, bool read_only) {
    const int mode = read_only ? SQLite::OPEN_READONLY : SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE;
    return SQLite::Database(path, mode | SQLite::OPEN_NOMUTEX, read_only ? 0 : kLockWaitMs);
}

// SQLiteCpp does not pass the system's error number on. It is asked of the connection where there is one.
Error error_of(const std::string& path, const SQLite::Exception& exception,
               const SQLite::Database* database) {
    const int system_error = database != nullptr ? sqlite3_system_errno(database->getHandle()) : 0;
    const int number = system_error != 0 ? system_error : EIO;
    switch (exception.getErrorCode() & 0xFF) {
        case SQLITE_BUSY:
        case SQLITE_LOCKED: return fail(Code::busy, path).error();
        case SQLITE_ERROR:       // our own statements do not fit the tables
        case SQLITE_CONSTRAINT:  // our own values keep to them: other rows are damaged
        case SQLITE_CORRUPT:
        case SQLITE_NOTADB: return fail(Code::malformed, path).error();
        case SQLITE_FULL: return fail(Code::io_failed, path, ENOSPC).error();
        case SQLITE_READONLY: return fail(Code::cannot_open, path, EACCES).error();
        case SQLITE_CANTOPEN: return fail(Code::cannot_open, path, number).error();
        default: return fail(Code::io_failed, path, number).error();
    }
}

Result<void> check_unmoved(const SQLite::Database& database, const std::string& path) {
    int moved = 0;
    sqlite3_file_control(database.getHandle(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
    if (moved != 0) return fail(Code::replaced, path);
    return {};
}

Result<FileContents> contents_of(const SQLite::Database& database, const std::string& path) {
    constexpr std::int64_t kChunk = 64 << 10;
    const auto failed = [&] { return fail(Code::io_failed, path, EIO); };
    sqlite3_file* file = nullptr;
    sqlite3_file_control(database.getHandle(), "main", SQLITE_FCNTL_FILE_POINTER, static_cast<void*>(&file));
    if (file == nullptr || file->pMethods == nullptr) return failed();
    sqlite3_int64 size = 0;
    if (file->pMethods->xFileSize(file, &size) != SQLITE_OK) return failed();
    FileContents contents{.size = size};
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min<std::int64_t>(size, kChunk)));
    for (std::int64_t at = 0; at < size; at += kChunk) {
        const auto count = static_cast<int>(std::min<std::int64_t>(size - at, kChunk));
        if (file->pMethods->xRead(file, bytes.data(), count, at) != SQLITE_OK) return failed();
        contents.checksum = crc32c(Bytes(bytes).first(static_cast<std::size_t>(count)), contents.checksum);
    }
    return contents;
}

}  // namespace takt::store
