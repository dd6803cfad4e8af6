#include "http/request_guard.hpp"

#include <arpa/inet.h>

#include <algorithm>

#include "http/lower_ascii.hpp"
#include "takt/base/ascii.hpp"
#include "takt/base/assert.hpp"

namespace takt::web {
namespace {

bool is_ipv4(const std::string& text) {
    in_addr address{};
    return ::inet_pton(AF_INET, text.c_str(), &address) == 1;
}

std::optional<in6_addr> ipv6(const std::string& text) {
    in6_addr address{};
    if (::inet_pton(AF_INET6, text.c_str(), &address) != 1) return std::nullopt;
    return address;
}

bool is_host_name(std::string_view text) {
    return !text.empty() && text.size() <= 253 && std::ranges::all_of(text, [](char c) {
        return is_digit(c) || (c >= 'a' && c <= 'z') || c == '-' || c == '.' || c == '_';
    });
}

bool is_port(std::string_view text) {
    return all_digits(text) && text.size() <= 5;
}

}  // namespace

bool equal_in_constant_time(std::string_view secret, std::string_view given) {
    unsigned difference = secret.size() == given.size() ? 0 : 1;
    for (std::size_t i = 0; i < given.size(); ++i) {
        const char expected = secret.empty() ? '\0' : secret[i % secret.size()];
        difference |= static_cast<unsigned>(static_cast<unsigned char>(expected ^ given[i]));
    }
    return difference == 0;
}

std::optional<std::string> host_name(std::string_view host) {
    if (host.starts_with('[')) {
        const auto end = host.find(']');
        if (end == std::string_view::npos) return std::nullopt;
        const auto rest = host.substr(end + 1);
        auto address = lower_ascii(host.substr(1, end - 1));
        if (!ipv6(address) || !(rest.empty() || (rest[0] == ':' && is_port(rest.substr(1)))))
            return std::nullopt;
        return address;
    }
    const auto colon = host.find(':');
    auto name = lower_ascii(host.substr(0, colon));
    if (!is_host_name(name) || (colon != std::string_view::npos && !is_port(host.substr(colon + 1))))
        return std::nullopt;
    return name;
}

bool is_loopback(std::string_view address) {
    const std::string text(address);
    if (is_ipv4(text)) return text.starts_with("127.");
    const auto parsed = ipv6(text);
    return parsed && IN6_IS_ADDR_LOOPBACK(&*parsed);
}

// A page of another site whose name leads to this machine sends its own name as Host. Names that no stranger
// can own, and addresses, are therefore enough; the port does not matter (it differs behind a tunnel).
bool RequestGuard::is_own_host(std::string_view host) const {
    const auto name = host_name(host);
    if (!name) return false;
    if (*name == "localhost" || is_loopback(*name)) return true;
    if (std::ranges::find(policy_.names, *name) != policy_.names.end()) return true;
    if (policy_.address.empty() || policy_.address == "0.0.0.0" || policy_.address == "::")
        return is_ipv4(*name) || ipv6(*name).has_value();
    return *name == lower_ascii(policy_.address);
}

bool RequestGuard::has_token(const GuardedRequest& request) const {
    if (policy_.token.empty()) return false;
    constexpr std::string_view kScheme = "bearer ";
    if (request.authorization) {
        const auto& text = *request.authorization;
        if (text.size() <= kScheme.size() || lower_ascii(text.substr(0, kScheme.size())) != kScheme)
            return false;
        return equal_in_constant_time(policy_.token, std::string_view(text).substr(kScheme.size()));
    }
    return request.reads && request.query_token &&
           equal_in_constant_time(policy_.token, *request.query_token);
}

std::optional<Refusal> RequestGuard::check(const GuardedRequest& request) const {
    if (!request.host || !is_own_host(*request.host)) return Refusal{421, "host"};
    if (request.forwarded_host && !is_own_host(*request.forwarded_host)) return Refusal{421, "host"};
    const auto origin =
        (request.tls ? "https://" : "http://") + lower_ascii(request.forwarded_host.value_or(*request.host));
    if (request.origin && lower_ascii(*request.origin) != origin) return Refusal{403, "origin"};
    if (!request.api) return std::nullopt;
    if (request.fetch_site && *request.fetch_site != "same-origin" && *request.fetch_site != "none")
        return Refusal{403, "origin"};
    if (!policy_.token.empty() && !has_token(request)) return Refusal{401, "token"};
    if (request.parameters > policy_.most_parameters || request.longest_parameter > policy_.longest_parameter)
        return Refusal{400, "query"};
    if (request.reads) return std::nullopt;
    if (request.changes && !policy_.allow_write) return Refusal{403, "read_only"};
    if (request.mark != "1") return Refusal{403, "mark"};
    const auto type = request.content_type.value_or("");
    if (lower_ascii(trimmed(std::string_view(type).substr(0, type.find(';')))) != "application/json")
        return Refusal{415, "content"};
    return std::nullopt;
}

PeerRates::PeerRates(std::uint32_t burst, Duration min_interval)
    : fresh_(TokenBucket::create(burst, min_interval).value()) {}

// When the table is full, addresses that are below their rate are forgotten. If all are above it, the new
// address is refused.
bool PeerRates::admit(const std::string& peer, Instant now) {
    auto found = peers_.find(peer);
    if (found == peers_.end()) {
        if (peers_.size() >= kMostPeers)
            std::erase_if(peers_,
                          [now](const auto& entry) { return entry.second.next_admission(now) <= now; });
        if (peers_.size() >= kMostPeers) return false;
        found = peers_.emplace(peer, fresh_).first;
    }
    return found->second.admit(now);
}

}  // namespace takt::web
