// Who may ask for what (specification, section 12).
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

/// At most `burst` requests at once, and then so many a second.
struct RateLimit {
    std::uint32_t per_second = 1;  ///< >= 1
    std::uint32_t burst = 1;       ///< 1..1'000'000
};

/// One rule. It speaks of requests that fit all it names; what it does not name fits always.
struct AccessRule {
    enum class Verdict : std::uint8_t { allow, read_only, deny };

    std::span<const Network> networks;  ///< of TCP peers
    bool serial = false;                ///< peers on serial ports
    bool every_peer = true;             ///< `networks` and `serial` do not count
    std::span<const UnitRange> units;   ///< empty: every unit
    FunctionSet functions = FunctionSet::all();
    std::optional<wire::Area> area;  ///< only requests that touch items of it
    AddressRanges items;             ///< with `area`: only these items of it; empty: all
    Verdict verdict = Verdict::deny;
    std::optional<RateLimit> rate;  ///< of each peer, for all requests this rule decides
};

/// Items of one area that a request touches.
struct Touched {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    bool write = false;
};

/// What a request is about, as far as its bytes tell.
struct RequestScope {
    std::uint8_t function = 0;
    bool writes = false;  ///< changes something; functions that are not known here count so
    std::uint8_t touches = 0;
    std::array<Touched, 2> touched;  ///< the first `touches` of them
};

/// @param request  1..253 bytes, whatever they are
[[nodiscard]] RequestScope scope_of(Bytes request);

/// The rate limit of one peer under one rule; storage of an AccessControl.
struct RateBucket {
    IpAddress peer;  ///< IPv6: its /64; a serial port: all zero
    std::uint32_t rule = 0;
    Instant seen;
    std::optional<TokenBucket> tokens;  ///< none: not in use
};

/// Decides by the first rule that fits; where there are rules and none fits, no. A request whose items are
/// decided by several rules is allowed when each of its items is.
///
/// The rules and what they refer to are the caller's, and stay as they are until the next set_rules(). Never
/// allocates. One owner, one thread.
class AccessControl {
public:
    enum class Decision : std::uint8_t {
        allowed,
        denied,     ///< exception 1
        read_only,  ///< exception 1: a rule lets it read, and it writes
        too_fast,   ///< exception 6
    };

    /// @param buckets  storage for the peers that are limited. When it is full, a new peer takes the bucket
    /// of
    ///                 the peer that was silent longest
    explicit AccessControl(std::span<RateBucket> buckets) : buckets_(buckets) {}

    /// No rules: everything is allowed. Forgets what the peers have left.
    void set_rules(std::span<const AccessRule> rules);
    [[nodiscard]] bool has_rules() const { return !rules_.empty(); }

    /// @param unit  the one that is meant: not 0 or 255 where these mean another
    [[nodiscard]] Decision decide(const Context& context, UnitId unit, const RequestScope& scope);

    /// Decides about a request as it came: units 0 and 255 mean the first unit where they are not served
    /// themselves, and a broadcast must be allowed for every unit.
    /// @param units   those of the server, in its order
    /// @param served  whether the server answers for the request's very unit: Responder::serves()
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

/// The answer to a request that was not allowed: exception 1, or 6 when it came too fast; silence for a
/// broadcast.
[[nodiscard]] Answer rejection(const Context& context, Bytes request, AccessControl::Decision decision);

}  // namespace takt::serve
