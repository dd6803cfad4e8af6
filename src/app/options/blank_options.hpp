// The values of the options that describe the blank device of `takt serve`.
#pragma once

#include <optional>
#include <string_view>

#include "takt/endpoint/blank_spec.hpp"

namespace takt::app {

using endpoint::BlankSpec;

/// Each parses one value; nothing: the text is not of that form. Numbers are decimal, or hexadecimal behind
/// 0x.
std::optional<BlankSpec::Range> parse_item_range(std::string_view text);    ///< "holding:0..99", "coils:7"
std::optional<BlankSpec::Limit> parse_value_limits(std::string_view text);  ///< "holding:0..9=-5..100"
std::optional<BlankSpec::File> parse_file_records(std::string_view text);   ///< "4:100": number, records
std::optional<BlankSpec::Fifo> parse_fifo(std::string_view text);           ///< "1246:440,4740"
std::optional<BlankSpec::Object> parse_object(std::string_view text);       ///< "0x80=text"

}  // namespace takt::app
