// Why the options of a command are not accepted.
#pragma once

#include <string>
#include <string_view>

#include "texts.hpp"

namespace takt::app {

/// A message ("app.option.…") and its arguments.
struct OptionError {
    std::string code;
    Texts::Arguments arguments;

    friend bool operator==(const OptionError&, const OptionError&) = default;
};

/// The error that CLI11 describes in English. Names and values are taken from its words.
/// Words that are not known become "app.option.other".
[[nodiscard]] OptionError option_error(std::string_view words);

}  // namespace takt::app
