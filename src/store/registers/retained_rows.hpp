// The rows of a file of retained values. These functions also throw SQLite::Exception; see with_results().
#pragma once

#include <map>
#include <string>
#include <vector>

#include "registers/database.hpp"
#include "takt/store/retained.hpp"

namespace takt::store {

/// Creates the tables of retained values in an empty database.
void make_tables(SQLite::Database& database);

/// @returns malformed (damaged, or of another program), unsupported (of a newer version)
[[nodiscard]] Result<std::vector<Retained>> read_rows(SQLite::Database& database, const std::string& path);

/// Writes all of `entries` in one transaction.
void write_rows(SQLite::Database& database, const std::map<std::string, Retained>& entries);

}  // namespace takt::store
