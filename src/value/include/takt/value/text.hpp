// Values as text: what users type and what is shown.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/value/value.hpp"

namespace takt::value {

/// Reads a value of that type. bool: true, false, 1, 0. Integers: decimal or 0x…, with a sign where the type
/// has one; no leading zeros. Floating point (and every scaled type): decimal or exponent, also nan, inf,
/// -inf; for an unscaled `float` rounded to the nearest float. string: the text as it is. Independent of the
/// locale.
/// @returns syntax (subject: the text), overflow (subject) when it does not fit the type
Result<Value> parse(DataType type, bool scaled, std::string_view text);

/// The shortest text that parse() reads back as the same value; a `float` with the digits of a float (0.1,
/// not 0.10000000149011612). Empty for no value.
std::string format(DataType type, bool scaled, const Value& value);

}  // namespace takt::value
