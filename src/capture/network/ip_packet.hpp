// TCP segments in IP packets without a link layer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "takt/capture/segment.hpp"

namespace takt::capture {

inline constexpr std::uint8_t kTcpProtocol = 6;      ///< in the header of IP
inline constexpr std::size_t kIpv4HeaderBytes = 20;  ///< without options

struct TcpHead {
    Endpoint source;  ///< both of the same version of IP
    Endpoint destination;
    std::uint32_t sequence = 0;
    std::uint32_t acknowledged = 0;
};

/// A packet of link type raw with PSH and ACK and good checksums.
/// @param payload  at most 65,000 bytes
[[nodiscard]] std::string tcp_packet(const TcpHead& head, std::string_view payload);

}  // namespace takt::capture
