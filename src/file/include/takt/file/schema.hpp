// The JSON Schema of project files.
#pragma once

#include <optional>
#include <string_view>

#include "takt/file/json.hpp"
#include "takt/model/fields.hpp"

namespace takt::file {

/// A schema (draft 2020-12) of a project file, as editors of YAML use it: all keys with their kinds, words
/// and ranges, made from model::fields(). Ranges that depend on other keys are the widest ones. Rules of the
/// interpretation are not in it: unique names, references, keys that exclude one another.
[[nodiscard]] Json project_schema();

/// The name of an object: "line", "device", "output_selection".
[[nodiscard]] std::string_view object_name(model::Object object);
/// The name of a kind: "integer", "local_bool".
[[nodiscard]] std::string_view kind_name(model::Kind kind);

/// The kind of the items of a list, or of the mapping behind a key.
[[nodiscard]] std::optional<model::Object> object_behind(std::optional<model::Object> object,
                                                         std::string_view key);

}  // namespace takt::file
