// The numbers of status variables (docs/specification.md, section 7).
#pragma once

#include <cstdint>

namespace takt {

/// The content of a status variable. A Modbus exception has a number of its own: exception_status().
enum class StatusCode : std::uint16_t {
    ok = 0,
    timeout = 100,
    bad_checksum = 101,
    unexpected_reply = 102,
    link_lost = 103,
    switched_off = 104,
    not_answering = 105,
    ambiguous = 110,  ///< the response may be that to an earlier request
};

constexpr std::uint16_t number(StatusCode status) {
    return static_cast<std::uint16_t>(status);
}

/// Of an exception with code 1..99 the code itself, of any other one (0, 100..255) 256 + code.
constexpr StatusCode exception_status(std::uint8_t code) {
    return StatusCode{code >= 1 && code <= 99 ? std::uint16_t{code} : static_cast<std::uint16_t>(256 + code)};
}

}  // namespace takt
