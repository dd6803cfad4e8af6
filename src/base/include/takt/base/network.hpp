// Addresses of peers and the networks they are in.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace takt {

/// An IPv6 address in the order of the wire; an IPv4 one as ::ffff:a.b.c.d (RFC 4291, section 2.5.5.2).
struct IpAddress {
    std::array<std::uint8_t, 16> bytes{};
    friend constexpr bool operator==(const IpAddress&, const IpAddress&) = default;

    [[nodiscard]] bool is_ipv4() const;
};

/// "192.0.2.7", "2001:db8::1", "fe80::1%eth0" (the zone counts for nothing). Nothing: it is none.
[[nodiscard]] std::optional<IpAddress> parse_ip(std::string_view text);

/// Of "192.0.2.7:50100" and "[2001:db8::1]:50100". Nothing: it is none, as a serial port.
[[nodiscard]] std::optional<IpAddress> parse_peer(std::string_view text);

/// All addresses whose first `bits` bits are those of `address`.
struct Network {
    IpAddress address;
    std::uint8_t bits = 0;  ///< 0..128; of an IPv4 network 96 more than it is written with
    friend constexpr bool operator==(const Network&, const Network&) = default;

    [[nodiscard]] bool contains(const IpAddress& other) const;
};

/// "192.0.2.0/24", "2001:db8::/32", or an address alone. Nothing: it is none.
[[nodiscard]] std::optional<Network> parse_network(std::string_view text);

}  // namespace takt
