// Keys that name commands and files of the host, and keys that decide where secrets go.
#pragma once

#include <functional>
#include <string>

#include "takt/file/load.hpp"
#include "takt/model/document.hpp"

namespace takt::web {

/// Finds values that only a person with access to the file may give: command lines, and files that the
/// program reads or writes outside the project's tables. An editor in a browser must not be able to run
/// commands, or to read and write files of the host, by changing the project
/// (docs/decisions/0044-editing-project-files.md). The field table marks the keys
/// (model::Field::names_host_resource).
/// @returns the key of the first such value of `wanted` that `old` does not have; empty: there is none
[[nodiscard]] std::string new_protected_key(const model::Node& old, const model::Node& wanted);

/// Finds a secret that would go elsewhere. Each secret of `wanted` whose value `old` has needs an object in
/// `old` with the same secret and the same directing keys (model::Field::secret, directs_secret). Names, the
/// order of items and their origins have no meaning, so neither an exchange of names nor a new item with the
/// secret of another one helps. An object without the secret may go anywhere.
/// @returns the first key that differs; empty: no secret goes elsewhere
[[nodiscard]] std::string redirecting_key(const model::Node& old, const model::Node& wanted);

/// Reads the tables and templates of a project: those that the file names, and others in its
/// folder whose names end as those of tables and templates do.
/// @param saved  the root of the file
[[nodiscard]] file::Reader restricted_reader(const std::string& project_file, const model::Node& saved);

}  // namespace takt::web
