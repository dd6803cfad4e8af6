// Opening the file of a history for writing.
#pragma once

#include <memory>
#include <string>

#include "registers/database.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::store {

/// The file, open and locked against a second writer. The lock is released last.
struct HistoryFile {
    os::Descriptor lock;
    std::unique_ptr<SQLite::Database> database;
};

/// Opens or creates the file.
/// @returns busy, unsupported, malformed, cannot_open, io_failed as History::open()
[[nodiscard]] Result<HistoryFile> open_history_file(const std::string& path);

/// Whether a file that SQLite cannot read may be a history: of a file of another program no page looks like
/// one of SQLite. Not for a file that this process writes: closing it would release the locks of SQLite.
/// @returns unsupported: it is of another program; malformed: it is damaged
[[nodiscard]] Result<void> check_history_mark(const std::string& path);

/// Moves a damaged file aside, with its write-ahead log. @returns the new path
[[nodiscard]] Result<std::string> set_history_aside(const std::string& path);

}  // namespace takt::store
