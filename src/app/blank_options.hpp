// The blank device of `takt serve` as its options describe it.
#pragma once

#include <optional>
#include <string_view>

#include "takt/endpoint/blank_spec.hpp"

namespace takt::app {

/// Values of the options, as they are typed; nothing: they cannot be read so. Numbers are decimal or 0x.
std::optional<endpoint::BlankSpec::Range> parse_item_range(
    std::string_view text);  ///< "holding:0..99", "coils:7"
std::optional<endpoint::BlankSpec::Limit> parse_value_limits(
    std::string_view text);  ///< "holding:0..9=-5..100"
std::optional<endpoint::BlankSpec::File> parse_file_records(
    std::string_view text);                                                      ///< "4:100": number, records
std::optional<endpoint::BlankSpec::Fifo> parse_fifo(std::string_view text);      ///< "1246:440,4740"
std::optional<endpoint::BlankSpec::Object> parse_object(std::string_view text);  ///< "0x80=text"

}  // namespace takt::app
