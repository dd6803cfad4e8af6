// The rows of a file of retained values.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "database.hpp"
#include "takt/store/retained.hpp"

namespace takt::store {

/// Makes an empty database one of retained values.
[[nodiscard]] Result<void> make_table(Database& database);

/// @returns malformed where it is damaged or of another program; unsupported where it is newer
[[nodiscard]] Result<std::vector<Retained>> read_rows(Database& database, const std::string& path);

/// All of `entries` in one transaction.
[[nodiscard]] Result<void> write_rows(Database& database, const std::map<std::string, Retained>& entries);

}  // namespace takt::store
