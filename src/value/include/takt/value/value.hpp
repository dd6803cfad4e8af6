// A value with its quality and reason.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "takt/base/data_type.hpp"
#include "takt/base/status_code.hpp"

namespace takt::value {

/// The value of a variable or a local. std::monostate: no value (yet).
///
/// bool for `bool`; std::int64_t for the signed and std::uint64_t for the unsigned integers; double for
/// `float` (exactly the float's value), `double` and every scaled variable; std::string for `string`.
using Value = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string>;

inline bool is_empty(const Value& value) {
    return std::holds_alternative<std::monostate>(value);
}

/// Equality for readers: the same alternative and value. Two NaN are equal; 0.0 and -0.0 are not.
bool same(const Value& a, const Value& b);

enum class Quality : std::uint8_t {
    never_read,  ///< nothing was read yet; the value is the default one, if there is one
    good,        ///< the last read succeeded; locals are always good
    uncertain,   ///< the last attempt failed and retries follow, or it is stale; the value is the last good
                 ///< one
    bad,         ///< the reads fail (see the reason); the value is the default or the last one
};
std::string_view name(Quality quality);

/// Why a value is not good; also the content of a status variable, see status_code(). A Modbus exception is
/// exception_reason().
enum class Reason : std::uint16_t {
    ok = number(StatusCode::ok),
    timeout = number(StatusCode::timeout),
    bad_checksum = number(StatusCode::bad_checksum),
    unexpected_reply = number(StatusCode::unexpected_reply),
    link_lost = number(StatusCode::link_lost),
    switched_off = number(StatusCode::switched_off),
    not_answering = number(StatusCode::not_answering),
    differs = 106,          ///< the value read back differs from the written one
    superseded = 107,       ///< of a command: another value was set before it was sent
    stale = 108,            ///< the value is older than its proved age, or than max_age
    never_connected = 109,  ///< the port was never open, the connection never made; status code 103
    ambiguous = number(StatusCode::ambiguous),  ///< the response may be that to an earlier request
    closed = 111,  ///< the peer closed the connection instead of answering; status code 103
};

constexpr Reason exception_reason(std::uint8_t code) {
    return Reason{number(exception_status(code))};
}
constexpr bool is_exception(Reason reason) {
    const auto number = static_cast<std::uint16_t>(reason);
    return (number >= 1 && number <= 99) || number >= 256;
}
constexpr std::uint16_t status_code(Reason reason) {
    const bool no_link = reason == Reason::never_connected || reason == Reason::closed;
    return static_cast<std::uint16_t>(no_link ? Reason::link_lost : reason);
}

/// "ok", "timeout", ..., "exception" for any exception.
std::string_view name(Reason reason);

}  // namespace takt::value
