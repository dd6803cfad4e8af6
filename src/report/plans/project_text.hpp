// Parts of project files that reports write.
#pragma once

#include <string>

#include "takt/model/line.hpp"

namespace takt::report {

/// A text in double quotes.
[[nodiscard]] std::string quoted_yaml(const std::string& text);

/// The keys of the connection of a line, one a line, indented.
[[nodiscard]] std::string connection_yaml(const model::Line& line);

}  // namespace takt::report
