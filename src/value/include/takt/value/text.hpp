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
/// @returns syntax, or overflow when it does not fit the type; subject: the text and what is allowed, "1.5 →
/// -32768..32767"
Result<Value> parse(DataType type, bool scaled, std::string_view text);

/// "1.5 → 0..65535": the subject of an error, what stands there and what may stand there. A long text is cut
/// so that both fit into a subject.
std::string beside_allowed(std::string_view text, std::string_view allowed);

/// The shortest text that parse() reads back as the same value; a `float` with the digits of a float (0.1,
/// not 0.10000000149011612). Empty for no value.
std::string format(DataType type, bool scaled, const Value& value);

}  // namespace takt::value
