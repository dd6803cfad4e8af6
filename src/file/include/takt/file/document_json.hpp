// Documents of project files as JSON: what an editor of a project reads and sends:
// docs/project-file.md, "The document".
//
// Mappings are objects in the order of the file, lists are arrays, each scalar is a string with its raw text,
// null is null. A mapping in a list has the additional key `$from` (kOriginKey), its index in that list.
#pragma once

#include <cstdint>
#include <string>

#include "takt/base/result.hpp"
#include "takt/file/edit.hpp"
#include "takt/file/json.hpp"
#include "takt/model/document.hpp"

namespace takt::file {

[[nodiscard]] Json document_json(const model::Node& root);

/// The document of such an object. Booleans and numbers become their texts. kOriginKey stays an entry of its
/// mapping; without_origins() removes it.
/// The nodes have no locations: their lines are those of a file that is not written yet.
/// @param original  the root of the file. A text that comes from it unchanged has its quotes. nullptr: none
/// @returns malformed (subject: the path), too_long (subject: the path; beyond the limits of files)
[[nodiscard]] Result<model::Node> document_of(const Json& json, const model::Node* original);

void without_origins(model::Node& node);
/// A copy of such JSON.
[[nodiscard]] Json without_origins(const Json& json);

}  // namespace takt::file
