// Keys that name commands and files of the host.
#pragma once

#include <functional>
#include <string>

#include "takt/file/load.hpp"
#include "takt/model/document.hpp"

namespace takt::web {

/// Finds values that only a person with access to the file may give: command lines, and files that the
/// program reads or writes outside the project's tables. An editor in a browser must not be able to run
/// commands, or to read and write files of the host, by changing the project
/// (docs/decisions/0044-editing-project-files.md).
/// @returns the key of the first such value of `wanted` that `old` does not have; empty: there is none
[[nodiscard]] std::string new_protected_key(const model::Node& old, const model::Node& wanted);

/// Reads the tables and templates of a project: those that the file names, and others in its
/// folder whose names end as those of tables and templates do.
/// @param saved  the root of the file
[[nodiscard]] file::Reader restricted_reader(const std::string& project_file, const model::Node& saved);

}  // namespace takt::web
