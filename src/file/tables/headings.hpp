// Headings of table columns.
#pragma once

#include <string>
#include <string_view>

#include "takt/model/fields.hpp"

namespace takt::file {

/// A column that only tables have: the number of registers, if the type does not imply it.
inline constexpr std::string_view kRegistersColumn = "registers";

/// Folds a text for comparison: lower-case letters and digits only; Cyrillic й and ї without their marks,
/// which some systems encode as separate characters, and ё as е.
std::string folded(std::string_view text);

/// The parts of a heading.
struct HeadingParts {
    std::string_view key;      ///< empty: unknown
    std::string unit;          ///< of durations: "ms", "s"…, as the project file has it
    bool hexadecimal = false;  ///< of addresses: `(hex)`
    bool ambiguous = false;    ///< cut, so that other keys begin so too
};

/// The field of a column: of a variable, or of a device for kDeviceSettings. nullptr: a column of tables
/// only.
const model::Field* column_field(std::string_view key);

HeadingParts read_heading(std::string_view text);

/// The name of a field of a window. As read_heading(), and the beginning of the heading of a setting of a
/// device where no other heading begins so: `Группировать`.
HeadingParts read_field_name(std::string_view text);

/// The known heading most similar to a text, and its key.
struct LikelyHeading {
    std::string_view heading;
    std::string_view key;
    bool typing_mistake = false;  ///< so similar that no other heading can be meant
};

LikelyHeading likely_heading(std::string_view text);

/// "ms" for `мс`; empty when it is no unit of time.
std::string_view time_unit(std::string_view text);

}  // namespace takt::file
