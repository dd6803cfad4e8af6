// Access rules: which peer may send which requests (docs/specification.md, section 12).
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
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
    /// Function 43 with MEI type 14, which reads, and with the other types, which may write. They count
    /// beside `functions`.
    bool identification = false;
    bool other_encapsulated = false;
    std::optional<wire::Area> area;  ///< only requests that touch items of it
    AddressRanges items;             ///< with `area`: only these items of it; empty: all
    Permission permission = Permission::deny;
    std::optional<RateLimit> rate;  ///< per peer, for all requests that this rule decides, also in part
};

/// Items of one area that a request touches. Behind item 65535 they continue at 0, because a device may do
/// the same.
struct Touched {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t first = 0;
    std::uint16_t count = 1;  ///< at least 1
    bool write = false;
};

/// What a request accesses, as far as its bytes show.
struct RequestScope {
    std::uint8_t function = 0;
    bool writes = false;  ///< changes something; also true for unknown functions
    /// The meaning of the request is the device's own: an undefined function, or another MEI type than 14. It
    /// may touch every item.
    bool any_item = false;
    bool identification = false;  ///< function 43, MEI type 14
    std::uint8_t touches = 0;
    std::array<Touched, 2> touched;  ///< the first `touches` of them
};

/// @param request  1..253 bytes; nothing is assumed of them
[[nodiscard]] RequestScope scope_of(Bytes request);

/// The remaining tokens of a peer; storage of an AccessControl.
struct RateBucket {
    IpAddress peer;  ///< rate_owner(); a serial port: all zero
    std::uint32_t rule = 0;
    Instant seen;
    std::optional<TokenBucket> tokens;  ///< none: not in use
};

/// Evaluates access rules: the first matching rule decides; if there are rules and none matches, the request
/// is denied. If several rules decide the items of a request, each item must be allowed, and the rate of each
/// of these rules is charged once.
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

    static constexpr std::size_t kMaxRules = 256;

    /// @param buckets  storage for rate-limited peers, one for each rule with a rate. If there are more
    /// peers,
    ///                 the one that was silent longest loses its bucket and starts with a full one
    explicit AccessControl(std::span<RateBucket> buckets) : buckets_(buckets) {}

    /// Without rules everything is allowed. Resets all buckets.
    /// @param rules  at most kMaxRules
    void set_rules(std::span<const AccessRule> rules);
    [[nodiscard]] bool has_rules() const { return !rules_.empty(); }

    /// Decides about a request, and charges the rates if it is allowed.
    /// @param units  all units that would execute the request; it must be allowed for each of them. A rule
    ///               with a rate is charged once, however many units it decides. None: the request is allowed
    [[nodiscard]] Decision decide(const Context& context, std::span<const UnitRange> units,
                                  const RequestScope& scope);
    [[nodiscard]] Decision decide(const Context& context, UnitId unit, const RequestScope& scope) {
        const UnitRange only{unit.value, unit.value};
        return decide(context, {&only, 1}, scope);
    }

    /// The same without the rates: for a request that was charged before.
    [[nodiscard]] Decision decide_again(const Context& context, std::span<const UnitRange> units,
                                        const RequestScope& scope) const;

private:
    struct Query;
    using Deciders = std::bitset<kMaxRules>;  // rules that decided some item

    [[nodiscard]] bool fits(const AccessRule& rule, const Query& query) const;
    [[nodiscard]] unsigned next_unit(unsigned unit) const;
    Decision decide_units(const Context& context, std::span<const UnitRange> units, const RequestScope& scope,
                          Deciders& deciders) const;
    Decision decide_unit(const Query& query, Deciders& deciders) const;
    Decision decide_touched(const Query& query, const Touched& touched, Deciders& deciders) const;
    Decision decide_items(const Query& query, wire::Area area, bool write, unsigned first, unsigned last,
                          std::size_t rule, Deciders& deciders) const;
    Decision decide_whole(const Query& query, Deciders& deciders) const;
    [[nodiscard]] bool charge(const Context& context, const Deciders& deciders);
    [[nodiscard]] RateBucket& bucket_of(Instant t, const IpAddress& peer, std::size_t rule);

    std::span<const AccessRule> rules_;
    std::span<RateBucket> buckets_;
};

/// The answer to a denied request: exception 1, or 6 beyond the rate limit; silence for a broadcast.
[[nodiscard]] Answer rejection(const Context& context, Bytes request, AccessControl::Decision decision);

}  // namespace takt::serve
