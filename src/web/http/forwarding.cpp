#include "http/forwarding.hpp"

#include <algorithm>

#include "http/lower_ascii.hpp"
#include "takt/base/ascii.hpp"

namespace takt::web {
namespace {

std::string_view take_last(std::string_view& list) {
    const auto comma = list.rfind(',');
    const auto last = comma == std::string_view::npos ? list : list.substr(comma + 1);
    list = comma == std::string_view::npos ? std::string_view() : list.substr(0, comma);
    return trimmed(last, " \t");
}

/// "10.0.0.5", "::1", "[::1]", and with a port as some proxies write it: "10.0.0.5:4711", "[::1]:4711".
std::string_view without_port(std::string_view text) {
    if (text.starts_with('[')) return text.substr(1, text.find(']') - 1);
    const auto colon = text.find(':');
    return colon != std::string_view::npos && text.find(':', colon + 1) == std::string_view::npos
               ? text.substr(0, colon)
               : text;
}

bool contains(std::span<const Network> networks, const IpAddress& address) {
    return std::ranges::any_of(networks, [&](const Network& its) { return its.contains(address); });
}

}  // namespace

ForwardedClient forwarded_client(std::string_view peer, const ForwardingFields& fields,
                                 std::span<const Network> proxies) {
    ForwardedClient client{.address = std::string(peer)};
    const auto socket = parse_ip(without_port(peer));
    if (!socket || !contains(proxies, *socket)) return client;
    auto list = fields.addresses;
    while (!list.empty()) {
        const auto part = without_port(take_last(list));
        const auto address = parse_ip(part);
        if (!address) break;
        client.address = part.substr(0, part.find('%'));
        if (!contains(proxies, *address)) break;
    }
    auto hosts = fields.host;
    auto schemes = fields.scheme;
    client.host = take_last(hosts);
    client.tls = lower_ascii(take_last(schemes)) == "https";
    return client;
}

std::string limit_key(std::string_view address) {
    const auto parsed = parse_ip(without_port(address));
    if (!parsed) return std::string(address);
    const auto owner = rate_owner(*parsed);
    return {owner.bytes.begin(), owner.bytes.end()};
}

}  // namespace takt::web
