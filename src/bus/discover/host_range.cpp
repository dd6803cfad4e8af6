#include "takt/bus/host_range.hpp"

#include <algorithm>

#include "discover/decimal.hpp"

namespace takt::bus {
namespace {

std::unexpected<Error> unreadable_hosts(std::string_view host, std::string_view example) {
    constexpr std::size_t kShown = 40;
    return fail(Code::syntax, std::string(host.substr(0, kShown)).append(" → ").append(example));
}

/// Four decimal numbers, none with a leading zero, which some programs read as octal.
std::optional<std::uint32_t> parse_ipv4(std::string_view text) {
    std::uint32_t address = 0;
    for (int i = 0; i < 4; ++i) {
        const auto dot = text.find('.');
        if ((dot == std::string_view::npos) != (i == 3)) return std::nullopt;
        const auto part = text.substr(0, dot);
        const auto number = parse_decimal(part);
        if (!number || *number > 255 || (part.size() > 1 && part.front() == '0')) return std::nullopt;
        address = address << 8U | *number;
        if (i < 3) text.remove_prefix(dot + 1);
    }
    return address;
}

std::optional<HostRange> network_range(std::uint32_t address, std::string_view prefix_text) {
    const auto prefix = parse_decimal(prefix_text);
    if (!prefix || *prefix > 32) return std::nullopt;
    const std::uint32_t host_bits = *prefix == 32 ? 0 : 0xFFFFFFFFU >> *prefix;
    const std::uint32_t network = address & ~host_bits;
    const std::uint32_t reserved = *prefix < 31 ? 1 : 0;  // a /31 has two hosts (RFC 3021)
    return HostRange{network + reserved, network + host_bits - reserved};
}

/// The end of a range: a whole address, or its last byte.
std::optional<std::uint32_t> parse_last(std::uint32_t first, std::string_view text) {
    if (const auto address = parse_ipv4(text)) return address;
    const auto byte = parse_decimal(text);
    if (!byte || *byte > 255) return std::nullopt;
    return (first & 0xFFFFFF00U) | *byte;
}

bool is_network_scheme(std::string_view scheme) {
    return scheme == "tcp" || scheme == "tls" || scheme == "rtu+tcp";
}

}  // namespace

std::string ipv4_text(std::uint32_t address) {
    std::string text = std::to_string(address >> 24U);
    for (const unsigned shift : {16U, 8U, 0U})
        text.append(".").append(std::to_string(address >> shift & 0xFFU));
    return text;
}

Result<std::optional<HostRange>> parse_host_range(std::string_view host) {
    const auto separator = host.find_first_of("-/");
    if (separator == std::string_view::npos) return std::optional<HostRange>();
    const auto first_text = std::string(host.substr(0, separator));
    const auto first = parse_ipv4(first_text);
    if (!first) return std::optional<HostRange>();  // a name with a dash
    const auto behind = host.substr(separator + 1);
    HostRange range;
    if (host[separator] == '/') {
        const auto network = network_range(*first, behind);
        if (!network) return unreadable_hosts(host, first_text + "/24");
        range = *network;
    } else {
        const auto last = parse_last(*first, behind);
        if (!last || *last < *first) return unreadable_hosts(host, first_text + "-254");
        range = {*first, *last};
    }
    if (range.size() > kMaxScanTargets)
        return fail(Code::out_of_range, host, static_cast<std::int64_t>(range.size()), 1, kMaxScanTargets);
    return range;
}

Result<std::optional<UrlRange>> parse_url_range(std::string_view url) {
    const auto colon = url.find("://");
    if (colon == std::string_view::npos || !is_network_scheme(url.substr(0, colon)))
        return std::optional<UrlRange>();
    const auto begin = colon + 3;
    const auto end = std::min(url.find(':', begin), url.size());
    TAKT_TRY(const auto hosts, parse_host_range(url.substr(begin, end - begin)));
    if (!hosts) return std::optional<UrlRange>();
    auto first_url = std::string(url.substr(0, begin)).append(ipv4_text(hosts->first));
    return UrlRange{*hosts, first_url.append(url.substr(end))};
}

}  // namespace takt::bus
