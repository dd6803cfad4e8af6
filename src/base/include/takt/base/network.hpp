// Network addresses of peers.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace takt {

/// An IPv6 address in network byte order; IPv4 as ::ffff:a.b.c.d (RFC 4291, section 2.5.5.2).
struct IpAddress {
    std::array<std::uint8_t, 16> bytes{};
    friend constexpr bool operator==(const IpAddress&, const IpAddress&) = default;

    [[nodiscard]] bool is_ipv4() const;
    /// Loopback, private (RFC 1918, RFC 4193) or link-local: no other network is between.
    [[nodiscard]] bool is_nearby() const;
};

/// Parses "192.0.2.7", "2001:db8::1", "fe80::1%eth0" (the zone is ignored). Nothing: no address.
[[nodiscard]] std::optional<IpAddress> parse_ip(std::string_view text);

/// The address in "192.0.2.7:50100" or "[2001:db8::1]:50100". Nothing: no address, for example a serial port.
[[nodiscard]] std::optional<IpAddress> parse_peer(std::string_view text);

/// The key of a peer for rate limits: an IPv4 address or an IPv6 /64, because a client controls all
/// addresses of its network.
[[nodiscard]] IpAddress rate_owner(const IpAddress& address);

/// The addresses whose first `bits` bits equal those of `address`.
struct Network {
    IpAddress address;
    std::uint8_t bits = 0;  ///< 0..128; for IPv4 the written prefix + 96
    friend constexpr bool operator==(const Network&, const Network&) = default;

    [[nodiscard]] bool contains(const IpAddress& other) const;
};

/// Parses "192.0.2.0/24", "2001:db8::/32", or a single address. Nothing: no network.
[[nodiscard]] std::optional<Network> parse_network(std::string_view text);

}  // namespace takt
