#include "takt/base/network.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>

namespace takt {
namespace {

constexpr std::size_t kIpv4At = 12;  // in the sixteen bytes
constexpr std::array<std::uint8_t, kIpv4At> kIpv4Prefix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};

std::optional<unsigned> parse_number(std::string_view text, unsigned greatest, int base,
                                     std::size_t most_digits) {
    unsigned value = 0;
    if (text.empty() || text.size() > most_digits) return std::nullopt;
    if (base == 10 && text.size() > 1 && text.front() == '0') return std::nullopt;  // to some it is octal
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc() || end != text.data() + text.size() || value > greatest) return std::nullopt;
    return value;
}

/// The text before the separator, and `text` becomes what is behind it; all of it where there is none.
std::string_view split_off(std::string_view& text, char separator) {
    const std::size_t at = text.find(separator);
    const std::string_view part = text.substr(0, at);
    text = at == std::string_view::npos ? std::string_view() : text.substr(at + 1);
    return part;
}

std::optional<IpAddress> parse_ipv4(std::string_view text) {
    IpAddress address;
    for (std::size_t i = 0; i < kIpv4At; ++i) address.bytes[i] = kIpv4Prefix[i];
    for (std::size_t i = 0; i < 4; ++i) {
        const bool last = i == 3;
        if (!last && text.find('.') == std::string_view::npos) return std::nullopt;
        const auto byte = parse_number(last ? text : split_off(text, '.'), 255, 10, 3);
        if (!byte) return std::nullopt;
        address.bytes[kIpv4At + i] = static_cast<std::uint8_t>(*byte);
    }
    return address;
}

/// Groups of 16 bits, the last two perhaps as an IPv4 address.
/// @returns how many bytes they are; nothing: they are no groups, or too many
std::optional<std::size_t> parse_groups(std::string_view text, std::array<std::uint8_t, 16>& bytes) {
    std::size_t size = 0;
    while (!text.empty()) {
        if (text.find(':') == std::string_view::npos && text.find('.') != std::string_view::npos) {
            const auto ipv4 = parse_ipv4(text);
            if (!ipv4 || size + 4 > bytes.size()) return std::nullopt;
            for (std::size_t i = 0; i < 4; ++i) bytes[size++] = ipv4->bytes[kIpv4At + i];
            return size;
        }
        const bool more = text.find(':') != std::string_view::npos;
        const auto group = parse_number(split_off(text, ':'), 0xFFFF, 16, 4);
        if (!group || size + 2 > bytes.size() || (more && text.empty())) return std::nullopt;
        bytes[size++] = static_cast<std::uint8_t>(*group >> 8);
        bytes[size++] = static_cast<std::uint8_t>(*group);
    }
    return size;
}

std::optional<IpAddress> parse_ipv6(std::string_view text) {
    IpAddress address;
    const std::size_t gap = text.find("::");
    if (gap == std::string_view::npos) {
        const auto size = parse_groups(text, address.bytes);
        if (size != address.bytes.size()) return std::nullopt;
        return address;
    }
    std::array<std::uint8_t, 16> tail{};
    const auto before = parse_groups(text.substr(0, gap), address.bytes);
    const auto behind = parse_groups(text.substr(gap + 2), tail);
    if (!before || !behind || *before + *behind > address.bytes.size() - 2) return std::nullopt;
    for (std::size_t i = 0; i < *behind; ++i) address.bytes[address.bytes.size() - *behind + i] = tail[i];
    return address;
}

}  // namespace

bool IpAddress::is_ipv4() const {
    for (std::size_t i = 0; i < kIpv4At; ++i)
        if (bytes[i] != kIpv4Prefix[i]) return false;
    return true;
}

bool IpAddress::is_nearby() const {
    static const std::array kNearby{*parse_network("127.0.0.0/8"),    *parse_network("10.0.0.0/8"),
                                    *parse_network("172.16.0.0/12"),  *parse_network("192.168.0.0/16"),
                                    *parse_network("169.254.0.0/16"), *parse_network("::1"),
                                    *parse_network("fc00::/7"),       *parse_network("fe80::/10")};
    return std::ranges::any_of(kNearby, [&](const Network& network) { return network.contains(*this); });
}

std::optional<IpAddress> parse_ip(std::string_view text) {
    if (text.find(':') == std::string_view::npos) return parse_ipv4(text);
    return parse_ipv6(text.substr(0, text.find('%')));
}

std::optional<IpAddress> parse_peer(std::string_view text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string_view::npos) return std::nullopt;
    std::string_view host = text.substr(0, colon);
    if (!host.empty() && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
    return parse_ip(host);
}

IpAddress rate_owner(const IpAddress& address) {
    constexpr std::size_t kNetwork = 8;  // bytes
    IpAddress owner = address;
    for (std::size_t i = kNetwork; i < owner.bytes.size() && !address.is_ipv4(); ++i) owner.bytes[i] = 0;
    return owner;
}

bool Network::contains(const IpAddress& other) const {
    constexpr unsigned kIpv4Bits = 8 * kIpv4At;
    if (bits < kIpv4Bits && other.is_ipv4()) return false;  // ::/0 means every IPv6 address
    const std::size_t whole = bits / 8U;
    for (std::size_t i = 0; i < whole; ++i)
        if (address.bytes[i] != other.bytes[i]) return false;
    const unsigned rest = bits % 8U;
    return rest == 0 || ((address.bytes[whole] ^ other.bytes[whole]) >> (8 - rest)) == 0;
}

std::optional<Network> parse_network(std::string_view text) {
    const bool has_bits = text.find('/') != std::string_view::npos;
    const std::string_view host = split_off(text, '/');
    const bool ipv4 = host.find(':') == std::string_view::npos;
    const auto address = parse_ip(host);
    const auto bits =
        has_bits ? parse_number(text, ipv4 ? 32 : 128, 10, 3) : std::optional(ipv4 ? 32U : 128U);
    if (!address || !bits) return std::nullopt;
    return Network{*address, static_cast<std::uint8_t>(*bits + (ipv4 ? 8 * kIpv4At : 0))};
}

}  // namespace takt
