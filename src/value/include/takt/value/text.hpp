// Values as text, for input and display.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/value/value.hpp"

namespace takt::value {

/// Parses a value of that type, independently of the locale.
///   - bool: true, false, 1, 0;
///   - integers: decimal or 0x…, signed types with an optional sign, no leading zeros;
///   - floating point and scaled types: decimal or exponent, also nan, inf, -inf; an unscaled `float` is
///     rounded to the nearest float;
///   - string: the text itself.
/// @returns syntax, or overflow beyond the type. The subject has the text and the range: "1.5 →
///          -32768..32767"
Result<Value> parse(DataType type, bool scaled, std::string_view text);

/// "1.5 → 0..65535": the subject of an error, from the given text and the allowed values. A long text is cut
/// so that both fit into a subject.
std::string beside_allowed(std::string_view text, std::string_view allowed);

/// The shortest text that parse() reads back as the same value; for a `float` the digits of a float (0.1, not
/// 0.10000000149011612). Empty for no value.
std::string format(DataType type, bool scaled, const Value& value);

}  // namespace takt::value
