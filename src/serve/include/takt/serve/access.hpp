// Access rules: which peer may send which requests (docs/specification.md, section 12).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/network.hpp"
#include "takt/base/token_bucket.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/bank.hpp"
#include "takt/wire/function.hpp"

namespace takt::serve {

/// Function codes 1..127.
class FunctionSet {
public:
    static constexpr FunctionSet all() { return FunctionSet({~0ULL, ~0ULL}); }

    constexpr FunctionSet() = default;
    constexpr void add(std::uint8_t code) { words_[code / 64 & 1] |= 1ULL << (code % 64); }
    [[nodiscard]] constexpr bool has(std::uint8_t code) const {
        return code < 128 && (words_[code / 64] >> (code % 64) & 1) != 0;
    }
    friend constexpr bool operator==(const FunctionSet&, const FunctionSet&) = default;

private:
    constexpr explicit FunctionSet(std::array<std::uint64_t, 2> words) : words_(words) {}
    std::array<std::uint64_t, 2> words_{};
};

/// Unit addresses first..last.
struct UnitRange {
    std::uint8_t first = 0;
    std::uint8_t last = 255;
};

/// A token bucket: at most `burst` requests at once, refilled at `per_second`.
struct RateLimit {
    std::uint32_t per_second = 1;  ///< >= 1
    std::uint32_t burst = 1;       ///< 1..1'000'000
};

/// One rule. It applies to requests that match all given conditions; an unset condition matches always.
struct AccessRule {
    enum class Permission : std::uint8_t { allow, read_only, deny };

    std::span<const Network> networks;  ///< of TCP peers
    bool serial = false;                ///< peers on serial ports
    bool every_peer = true;             ///< `networks` and `serial` do not count
    std::span<const UnitRange> units;   ///< empty: every unit
    FunctionSet functions = FunctionSet::all();
    std::optional<wire::Area> area;  ///< only requests that touch items of it
    AddressRanges items;             ///< with `area`: only these items of it; empty: all
    Permission permission = Permission::deny;
    std::optional<RateLimit> rate;  ///< per peer, for all requests that this rule decides
};

/// Items of one area that a request touches.
struct Touched {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    bool write = false;
};

/// What a request accesses, as far as its bytes show.
struct RequestScope {
    std::uint8_t function = 0;
    bool writes = false;  ///< changes something; also true for unknown functions
    std::uint8_t touches = 0;
    std::array<Touched, 2> touched;  ///< the first `touches` of them
};

/// @param request  1..253 bytes; nothing is assumed of them
[[nodiscard]] RequestScope scope_of(Bytes request);

/// The remaining tokens of a peer; storage of an AccessControl.
struct RateBucket {
    IpAddress peer;  ///< IPv6: its /64; a serial port: all zero
    std::uint32_t rule = 0;
    Instant seen;
    std::optional<TokenBucket> tokens;  ///< none: not in use
};

/// Evaluates access rules: the first matching rule decides; if there are rules and none matches, the request
/// is denied. If several rules decide the items of a request, each item must be allowed.
///
/// The caller owns the rules and everything they refer to, and keeps them unchanged until the next
/// set_rules(). Never allocates. One owner, one thread.
class AccessControl {
public:
    enum class Decision : std::uint8_t {
        allowed,
        denied,     ///< exception 1
        read_only,  ///< exception 1: a write, where the rule allows only reads
        too_fast,   ///< exception 6
    };

    /// @param buckets  storage for rate-limited peers. If there are more peers, the one that was silent
    ///                 longest loses its bucket and starts with a full one
    explicit AccessControl(std::span<RateBucket> buckets) : buckets_(buckets) {}

    /// Without rules everything is allowed. Resets all buckets.
    void set_rules(std::span<const AccessRule> rules);
    [[nodiscard]] bool has_rules() const { return !rules_.empty(); }

    /// @param unit  the addressed unit, after 0 and 255 are resolved
    [[nodiscard]] Decision decide(const Context& context, UnitId unit, const RequestScope& scope);

    /// Decides about a request as received: units 0 and 255 mean the first unit if they are not served
    /// themselves; a broadcast must be allowed for every unit.
    /// @param units  those of the server, in order
    /// @param served  Responder::serves() for the request's unit
    [[nodiscard]] Decision admit(const Context& context, std::span<const UnitId> units, bool served,
                                 const RequestScope& scope);

private:
    struct Query;

    [[nodiscard]] bool fits(const AccessRule& rule, const Query& query) const;
    Decision decide_items(const Query& query, const Touched& touched, unsigned first, unsigned last,
                          std::size_t rule, std::size_t& decider) const;
    Decision decide_whole(const Query& query, std::size_t& decider) const;
    [[nodiscard]] bool take_token(const Query& query, std::size_t rule);
    [[nodiscard]] RateBucket& bucket_of(const IpAddress& peer, std::uint32_t rule);

    std::span<const AccessRule> rules_;
    std::span<RateBucket> buckets_;
};

/// The answer to a denied request: exception 1, or 6 beyond the rate limit; silence for a broadcast.
[[nodiscard]] Answer rejection(const Context& context, Bytes request, AccessControl::Decision decision);

}  // namespace takt::serve
