// Which requests are admitted: the rules against other pages in the browser of a user, and against strangers.
// docs/web.md, "Security".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/base/token_bucket.hpp"

namespace takt::web {

/// What the rules read of a request. Nothing: the field is not there.
struct GuardedRequest {
    bool api = true;       ///< below /api; the page itself holds no secret
    bool reads = true;     ///< GET or HEAD
    bool changes = false;  ///< the route needs --allow-write
    bool tls = false;      ///< the browser's connection, which may end at a proxy, is encrypted
    std::optional<std::string> host;
    std::optional<std::string> forwarded_host;  ///< X-Forwarded-Host of a proxy that counts
    std::optional<std::string> origin;
    std::optional<std::string> fetch_site;  ///< Sec-Fetch-Site
    std::optional<std::string> mark;        ///< X-Takt
    std::optional<std::string> content_type;
    std::optional<std::string> authorization;
    std::optional<std::string> query_token;
    std::size_t parameters = 0;
    std::size_t longest_parameter = 0;
};

/// The answer to a request that is rejected. The text of the code is "web.error.CODE".
struct Refusal {
    int status = 0;
    std::string_view code;
    friend bool operator==(const Refusal&, const Refusal&) = default;
};

struct GuardPolicy {
    std::string address = "127.0.0.1";    ///< bound to; empty: all addresses
    std::vector<std::string> names = {};  ///< further host names of the machine
    std::string token = {};               ///< empty: none is needed
    bool allow_write = false;
    std::size_t most_parameters = 64;
    std::size_t longest_parameter = 1024;
};

/// Rules without state. Any thread.
class RequestGuard {
public:
    explicit RequestGuard(GuardPolicy policy) : policy_(std::move(policy)) {}

    /// @returns nothing: admitted
    ///
    /// 421 host       the Host field, or that of a proxy, is none of: the bound address, a loopback name,
    ///                a name of the policy (DNS rebinding)
    /// 403 origin     another site's page asks, or there is an Origin that is not the Host
    /// 401 token      with a token: it is missing or wrong
    /// 400 query      too many or too long parameters
    /// 403 read_only  a change without --allow-write
    /// 403 mark       POST or PUT without `X-Takt: 1` (CSRF)
    /// 415 content    POST or PUT without `Content-Type: application/json`
    [[nodiscard]] std::optional<Refusal> check(const GuardedRequest& request) const;

    /// With a token: whether the request has it.
    [[nodiscard]] bool has_token(const GuardedRequest& request) const;

private:
    [[nodiscard]] bool is_own_host(std::string_view host) const;

    GuardPolicy policy_;
};

/// Compares in a time that depends on the length of `given` only.
[[nodiscard]] bool equal_in_constant_time(std::string_view secret, std::string_view given);

/// "127.0.0.1:8502", "[::1]:8502", "localhost": the name in lower case, an IPv6 address without brackets.
/// @returns nothing: not valid
[[nodiscard]] std::optional<std::string> host_name(std::string_view host);

/// An address that only this machine reaches: 127.0.0.0/8, ::1.
[[nodiscard]] bool is_loopback(std::string_view address);

/// A token bucket for each client address. One thread.
class PeerRates {
public:
    /// @param burst         requests at once
    /// @param min_interval  least mean distance of requests
    PeerRates(std::uint32_t burst, Duration min_interval);

    [[nodiscard]] bool admit(const std::string& peer, Instant now);

    static constexpr std::size_t kMostPeers = 1024;

private:
    TokenBucket fresh_;
    std::unordered_map<std::string, TokenBucket> peers_;
};

}  // namespace takt::web
