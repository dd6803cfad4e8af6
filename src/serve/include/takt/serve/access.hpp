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
#include "takt/wire/request_view.hpp"

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

    std::span<const Network> networks;        ///< of TCP peers
    bool serial = false;                      ///< peers on serial ports
    bool every_peer = true;                   ///< `networks` and `serial` do not count
    std::span<const std::string_view> roles;  ///< Context::role is one of them; empty: any, or none
    std::span<const UnitRange> units;         ///< empty: every unit
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
    ///                 peers, the one that was silent longest loses its bucket and starts with a full one
    explicit AccessControl(std::span<RateBucket> buckets) : buckets_(buckets) {}

    /// Without rules everything is allowed. Resets all buckets.
    /// @param rules  at most kMaxRules
    void set_rules(std::span<const AccessRule> rules);
    [[nodiscard]] bool has_rules() const { return !rules_.empty(); }

    /// Decides about a request, and charges the rates if it is allowed.
    /// @param units  all units that would execute the request; it must be allowed for each of them. A rule
    ///               with a rate is charged once, however many units it decides. None: the request is allowed
    [[nodiscard]] Decision decide(const Context& context, std::span<const UnitRange> units,
                                  const wire::RequestView& request);
    [[nodiscard]] Decision decide(const Context& context, UnitId unit, const wire::RequestView& request) {
        const UnitRange only{unit.value, unit.value};
        return decide(context, {&only, 1}, request);
    }

    /// The same without the rates: for a request that was charged before.
    [[nodiscard]] Decision decide_again(const Context& context, std::span<const UnitRange> units,
                                        const wire::RequestView& request) const;

private:
    struct Query;
    using Deciders = std::bitset<kMaxRules>;  // rules that decided some item

    [[nodiscard]] bool fits(const AccessRule& rule, const Query& query) const;
    [[nodiscard]] unsigned next_unit(unsigned unit) const;
    Decision decide_units(const Context& context, std::span<const UnitRange> units,
                          const wire::RequestView& request, Deciders& deciders) const;
    Decision decide_unit(const Query& query, Deciders& deciders) const;
    Decision decide_access(const Query& query, const wire::ItemAccess& access, Deciders& deciders) const;
    Decision decide_items(const Query& query, wire::Area area, bool write, unsigned first, unsigned last,
                          std::size_t rule, Deciders& deciders) const;
    Decision decide_whole(const Query& query, Deciders& deciders) const;
    [[nodiscard]] bool charge(const Context& context, const Deciders& deciders);
    [[nodiscard]] RateBucket& bucket_of(Instant t, const IpAddress& peer, std::size_t rule);

    std::span<const AccessRule> rules_;
    std::span<RateBucket> buckets_;
};

/// The answer to a denied request: exception 1, or 6 beyond the rate limit; silence for a broadcast.
[[nodiscard]] Answer rejection(const Context& context, const wire::RequestView& request,
                               AccessControl::Decision decision);

}  // namespace takt::serve
