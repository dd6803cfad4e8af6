// The text of a value in the command of an instrument. Pure.
#pragma once

#include <optional>
#include <string>

#include "takt/base/result.hpp"
#include "takt/model/instrument.hpp"
#include "takt/value/value.hpp"

namespace takt::endpoint {

inline constexpr std::size_t kMostValueText = 64;  ///< characters of a value in a command

/// The value as the command writes it, within its range.
///
/// A number is in fixed notation, without an exponent: with `decimals` rounded to so many digits, without
/// them with as many digits as needed (those of a float, if it is one). `{value:hex}` is an integer from 0 in
/// upper-case hexadecimal digits. A text has 1..kMostValueText letters, digits, blanks and `. _ + - /`,
/// but not the byte that follows the placeholder: so it cannot end the line or begin another command.
/// @returns out_of_range for every other value
Result<std::string> command_text(const model::InstrumentCommand& command, const value::Value& value);

/// The same without a range, for a value that was read: equal values have equal texts.
std::optional<std::string> value_text(const model::InstrumentCommand& command, const value::Value& value);

/// The bytes of the command with that text.
std::string command_bytes(const model::InstrumentCommand& command, const std::string& text);

}  // namespace takt::endpoint
