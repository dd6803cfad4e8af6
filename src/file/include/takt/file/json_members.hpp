// Reads the members of JSON that this module has made; a member that is missing reads as nothing.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"

namespace takt::report {

/// null: there is none.
[[nodiscard]] const file::Json& member(const file::Json& object, std::string_view key);
[[nodiscard]] std::string string_member(const file::Json& object, std::string_view key);
[[nodiscard]] std::optional<double> number_member(const file::Json& object, std::string_view key);
/// A whole number; "0" if there is none.
[[nodiscard]] std::string count_member(const file::Json& object, std::string_view key);
/// Of milliseconds.
[[nodiscard]] std::optional<Duration> time_member(const file::Json& object, std::string_view key);
[[nodiscard]] const file::Json::Array& array_member(const file::Json& object, std::string_view key);

}  // namespace takt::report
