// Command lines parsed without running a command: parsed_commands.cpp has the commands, which keep what they
// are given. In the place of takt_app's own when the test is linked.
#pragma once

#include <gtest/gtest.h>

#include <any>
#include <optional>
#include <string>

#include "options/option_error.hpp"

namespace takt::app::test {

/// The result of parsing a line of arguments, divided at blanks. "''" is an empty argument.
struct Parsed {
    std::any options;                  ///< of the command; empty: the line was not accepted
    std::optional<OptionError> error;  ///< why not
    std::string text;                  ///< the help, where it was asked for
};
[[nodiscard]] Parsed parse(const std::string& line);

/// The options that the line gives to its command, which must be the one with `Options`.
template <class Options>
[[nodiscard]] Options options_of(const std::string& line) {
    const auto parsed = parse(line);
    const auto* const options = std::any_cast<Options>(&parsed.options);
    EXPECT_NE(options, nullptr) << line << ": " << (parsed.error ? parsed.error->code : "another command");
    return options ? *options : Options{};
}

}  // namespace takt::app::test
