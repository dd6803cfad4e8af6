// Creates, recognises and upgrades the tables of a history. All functions throw SQLite::Exception.
#pragma once

#include <string>

#include "registers/database.hpp"
#include "takt/base/result.hpp"

namespace takt::store {

/// Creates the tables in an empty file.
void make_history_tables(SQLite::Database& database);
/// Whether it is a database without tables and of no program.
[[nodiscard]] bool is_empty_history(SQLite::Database& database);
/// @returns malformed: not a history; unsupported: of a newer version
[[nodiscard]] Result<void> check_history(SQLite::Database& database, const std::string& path);

/// Upgrades a file of version 1 in one transaction: its rows get checksums, as they are. Chunks are not read.
void upgrade_history(SQLite::Database& database);
/// Builds each index again that does not have the entries of its table. Reads all entries, and their rows.
void repair_indexes(SQLite::Database& database);
/// Gives this connection, which reads, temporary views of a file of version 1: its rows have no sums.
void view_history(SQLite::Database& database);

}  // namespace takt::store
