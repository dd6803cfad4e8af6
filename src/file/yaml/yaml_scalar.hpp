// Scalars as text of a YAML file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "takt/model/fields.hpp"
#include "yaml/yaml_layout.hpp"

namespace takt::file {

/// Words that a reader of YAML 1.1 or 1.2 takes for a boolean, in lower case.
inline constexpr std::array<std::string_view, 8> kBooleanWords{"true", "false", "yes", "no",
                                                               "on",   "off",   "y",   "n"};

/// The use of a scalar. It decides about quotes.
enum class ScalarUse : std::uint8_t {
    any,     ///< unknown: quoted where the text would not come back
    number,  ///< a number, a time, a boolean: quotes are an error
    text,    ///< a text: also quoted where other readers would take it for a number or a boolean
    digits,  ///< a text of digits: always quoted
};

/// The use of a field's value.
/// @param object  of the mapping; nothing: unknown
/// @param owner   the mapping
[[nodiscard]] ScalarUse use_of(std::optional<model::Object> object, const model::Node& owner,
                               std::string_view key);

/// Plain if possible, else in double quotes.
/// @param flow  inside brackets
[[nodiscard]] std::string scalar_text(std::string_view text, ScalarUse use, bool flow);

/// The text in the style of the scalar that it replaces, where that style can hold it.
[[nodiscard]] std::string scalar_text_like(std::string_view text, ScalarUse use, bool flow,
                                           const Layout& replaced, std::string_view file_text,
                                           std::string_view line_break);

}  // namespace takt::file
