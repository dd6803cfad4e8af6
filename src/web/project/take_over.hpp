// The rows of a table or of a device template as a part of the project file.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "takt/file/json.hpp"

namespace takt::web {

/// What takes the place of a name of a file.
struct TakenOver {
    std::string path;  ///< of the value: the list of a table, the device of a template
    file::Json value;
};

/// @param own       the document of the project file, as an editor sent it. What it has keeps its `$from`
/// @param complete  the same with what other files contain
/// @param path      of the name: "locals", "lines[0].devices[2].variables", or that of a `device_template`
/// @returns nothing: there is no name of a table or template
[[nodiscard]] std::optional<TakenOver> taken_over(const file::Json& own, const file::Json& complete,
                                                  std::string_view path);

}  // namespace takt::web
