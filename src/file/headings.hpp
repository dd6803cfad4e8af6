// What the columns of a table are called.
#pragma once

#include <string>
#include <string_view>

namespace takt::file {

/// A column of its own in tables: the registers of a value, where the type does not tell.
inline constexpr std::string_view kRegistersColumn = "registers";

/// A text as it is compared: letters and digits in small letters, nothing else; Cyrillic й and ї without
/// their marks, which some systems write as characters of their own, and ё as е.
std::string folded(std::string_view text);

/// A heading taken apart.
struct HeadingParts {
    std::string_view key;      ///< empty: not known
    std::string unit;          ///< of durations: "ms", "s"…, as the project file has it
    bool hexadecimal = false;  ///< of addresses: `(hex)`
};

HeadingParts read_heading(std::string_view text);

/// The heading that is most like a text, and its key.
struct LikelyHeading {
    std::string_view heading;
    std::string_view key;
    bool typing_mistake = false;  ///< so like it that nothing else can be meant
};

LikelyHeading likely_heading(std::string_view text);

/// "ms" for `мс`; empty when it is no unit of time.
std::string_view time_unit(std::string_view text);

}  // namespace takt::file
