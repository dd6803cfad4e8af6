// A request given as bytes.
#pragma once

#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::client {

/// The bytes of a request PDU from words of hexadecimal digits; "0x" before a word and blanks, colons and
/// commas within are ignored.
/// @returns syntax with the digits that cannot be read, too_long (bytes, limit)
[[nodiscard]] Result<wire::Pdu> parse_pdu(const std::vector<std::string>& words);

}  // namespace takt::client
