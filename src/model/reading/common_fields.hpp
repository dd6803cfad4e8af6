// Keys shared by several objects.
#pragma once

#include <algorithm>
#include <array>

#include "reading/field_ranges.hpp"
#include "takt/model/byte_order.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/notation.hpp"

namespace takt::model {

/// Concatenates tables.
template <std::size_t... sizes>
constexpr auto joined(const Field (&... parts)[sizes]) {
    std::array<Field, (sizes + ...)> all;
    auto end = all.begin();
    ((end = std::ranges::copy(parts, end).out), ...);
    return all;
}

inline constexpr Field kNameKey{.key = "name", .required = true, .range = kName};
inline constexpr Field kPortKey{.key = "port", .range = between<1, 255>};
inline constexpr Field kHostKey{.key = "host", .range = between<1, 255>};
inline constexpr Field kTcpPortKey{.key = "tcp_port", .kind = Kind::integer, .range = between<1, 65535>};
inline constexpr Field kTlsKey{.key = "tls", .kind = Kind::mapping, .object = Object::tls};
inline constexpr Field kBaudKey{.key = "baud", .kind = Kind::integer, .range = baud};
inline constexpr Field kParityKey{.key = "parity", .kind = Kind::word, .words = kParities};
inline constexpr Field kStopBitsKey{.key = "stop_bits", .kind = Kind::integer, .range = between<1, 2>};
inline constexpr Field kHighByteFirstKey{.key = "high_byte_first", .kind = Kind::boolean};
inline constexpr Field kHighRegisterFirstKey{.key = "high_register_first", .kind = Kind::boolean};
inline constexpr Field kByteOrderKey{.key = "byte_order", .kind = Kind::word, .words = kByteOrders};
inline constexpr Field kNotationKey{.key = "notation", .kind = Kind::word, .words = kNotations};
inline constexpr Field kCommentKey{.key = "comment", .range = kComment};
inline constexpr Field kBackoffKey{
    .key = "backoff", .kind = Kind::duration, .range = kLongTime, .object = Object::backoff};

/// Framing and character format.
inline constexpr Field kFrameKeys[] = {
    {.key = "framing", .kind = Kind::word, .words = kFramings, .fits = framing_fits},
    kBaudKey,
    kParityKey,
    kStopBitsKey,
    {.key = "data_bits", .kind = Kind::integer, .range = data_bits},
    {.key = "rs485", .kind = Kind::word, .words = kRs485},
};

}  // namespace takt::model
