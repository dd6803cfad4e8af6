// Why the options of a command are not accepted.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "texts.hpp"

namespace takt::app {

/// A message ("app.option.…") and its arguments.
struct OptionError {
    std::string code;
    Texts::Arguments arguments;
    std::optional<Error> why = {};  ///< the argument {why}, in words

    friend bool operator==(const OptionError&, const OptionError&) = default;
};

/// The error that CLI11 describes in English. Names and values are taken from its words.
/// Words that are not known become "app.option.other".
[[nodiscard]] OptionError option_error(std::string_view words);

/// The value is none of the allowed words, which are separated by ", ". The nearest one is named if there is
/// one.
[[nodiscard]] OptionError word_error(std::string_view option, std::string_view value,
                                     std::string_view allowed);

/// A command has no such option. The nearest one is named, or the argument that takes the value, or the key
/// of the project file.
/// @param options  as "--unit", and the arguments of the command as "START"
[[nodiscard]] OptionError unknown_option(const std::string& name, std::span<const std::string_view> options);

/// The error of a URL that line::parse_target() or the parsers of bus_discover do not accept.
/// @param option  the name of the option or argument
[[nodiscard]] OptionError target_error(std::string_view option, std::string_view url, const Error& why);

[[nodiscard]] std::string option_error_text(const Texts& texts, const OptionError& error);

}  // namespace takt::app
