// Reads members of JSON objects. A member that is missing, or has another type, reads as nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"

namespace takt::file {

/// null: there is none.
[[nodiscard]] const Json& member(const Json& object, std::string_view key);
/// nullptr: the value is no text.
[[nodiscard]] const std::string* text_in(const Json& value);
/// No items: the value is no list.
[[nodiscard]] const Json::Array& items_of(const Json& value);
/// A text as it is, other values in JSON, null as nothing.
[[nodiscard]] std::string scalar_text(const Json& value);

[[nodiscard]] std::string string_member(const Json& object, std::string_view key,
                                        std::string_view otherwise = {});
[[nodiscard]] std::optional<double> number_member(const Json& object, std::string_view key);
/// A whole number; a larger one than fits becomes the largest.
[[nodiscard]] std::optional<std::int64_t> whole_member(const Json& object, std::string_view key);
[[nodiscard]] bool flag_member(const Json& object, std::string_view key, bool otherwise = false);
/// A whole number; "0" if there is none.
[[nodiscard]] std::string count_member(const Json& object, std::string_view key);
/// Of milliseconds.
[[nodiscard]] std::optional<Duration> time_member(const Json& object, std::string_view key);
[[nodiscard]] const Json::Array& array_member(const Json& object, std::string_view key);
/// The texts of a list.
[[nodiscard]] std::vector<std::string> strings_member(const Json& object, std::string_view key);

}  // namespace takt::file
