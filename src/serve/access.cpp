// Evaluation of access rules, first match wins:
//   - a rule matches by peer, unit, function and area; a rule with items decides only those items, and the
//     remaining ones go on to the next rule;
//   - a request is allowed if each of its items is, for each unit that executes it; items that no rule
//     decides are denied;
//   - a request without items (function 8, for example) skips the rules that name an area;
//   - a request whose items only the device knows (an undefined function) counts as a write of every item;
//   - each rule with a rate that decided some item has a token bucket per peer. The request needs a token of
//     each, and takes none if one is missing.
#include "takt/serve/access.hpp"

#include <algorithm>

#include "pdu_bytes.hpp"
#include "takt/base/assert.hpp"

namespace takt::serve {
namespace {

using wire::Area;
using wire::Function;
using Decision = AccessControl::Decision;
using Permission = AccessRule::Permission;

constexpr unsigned kLastItem = 0xFFFF;

Decision decision_of(const AccessRule& rule, bool writes) {
    switch (rule.permission) {
        case Permission::allow: return Decision::allowed;
        case Permission::read_only: return writes ? Decision::read_only : Decision::allowed;
        case Permission::deny: break;
    }
    return Decision::denied;
}

TokenBucket full_bucket(const RateLimit& rate) {
    constexpr Duration kSecond = std::chrono::seconds(1);
    const auto bucket = TokenBucket::create(rate.burst, std::max(kSecond / rate.per_second, Duration(1)));
    TAKT_ASSERT(bucket);
    return *bucket;
}

}  // namespace

struct AccessControl::Query {
    const wire::RequestView& request;
    std::optional<IpAddress> peer;
    std::string_view role;
    UnitId unit;
    bool writes = request.effect() == wire::Effect::write;
    // Function 43: MEI type 14, or another one.
    bool encapsulated = request.function() == Function::encapsulated_interface && request.sub_function();
    bool identification = encapsulated && !writes;
    bool other_encapsulated = encapsulated && writes;
    // The meaning of the request is the device's own: it may touch every item.
    bool any_item = other_encapsulated || !wire::is_known(request.function());
};

void AccessControl::set_rules(std::span<const AccessRule> rules) {
    TAKT_ASSERT(rules.size() <= kMaxRules);
    rules_ = rules;
    std::ranges::fill(buckets_, RateBucket{});
}

bool AccessControl::fits(const AccessRule& rule, const Query& query) const {
    const bool encapsulated =
        query.identification ? rule.identification : query.other_encapsulated && rule.other_encapsulated;
    if (!encapsulated && !rule.functions.has(static_cast<std::uint8_t>(query.request.function())))
        return false;
    const auto holds = [&](const UnitRange& range) {
        return range.first <= query.unit.value && query.unit.value <= range.last;
    };
    if (!rule.units.empty() && std::ranges::none_of(rule.units, holds)) return false;
    if (!rule.roles.empty() && std::ranges::find(rule.roles, query.role) == rule.roles.end()) return false;
    if (rule.every_peer) return true;
    if (!query.peer) return rule.serial;
    return std::ranges::any_of(rule.networks,
                               [&](const Network& network) { return network.contains(*query.peer); });
}

// The next unit that some rule distinguishes from its predecessor, so that a broadcast is decided once for
// all units that the rules treat alike.
unsigned AccessControl::next_unit(unsigned unit) const {
    unsigned next = 256;
    for (const AccessRule& rule : rules_)
        for (const UnitRange& range : rule.units)
            for (const unsigned edge : {unsigned{range.first}, range.last + 1U})
                if (edge > unit) next = std::min(next, edge);
    return next;
}

Decision AccessControl::decide_units(const Context& context, std::span<const UnitRange> units,
                                     const wire::RequestView& request, Deciders& deciders) const {
    if (rules_.empty()) return Decision::allowed;
    Query query{request, parse_peer(context.peer), context.role, {}};
    for (const UnitRange& range : units)
        for (unsigned unit = range.first; unit <= range.last; unit = next_unit(unit)) {
            query.unit = UnitId{static_cast<std::uint8_t>(unit)};
            if (const auto decision = decide_unit(query, deciders); decision != Decision::allowed)
                return decision;
        }
    return Decision::allowed;
}

Decision AccessControl::decide_unit(const Query& query, Deciders& deciders) const {
    Decision decision = Decision::allowed;
    for (const wire::ItemAccess& access : query.request.accesses())
        if (decision == Decision::allowed) decision = decide_access(query, access, deciders);
    if (!query.request.accesses().empty()) return decision;
    if (!query.any_item) return decide_whole(query, deciders);
    for (const Area area : {Area::coil, Area::discrete_input, Area::input_register, Area::holding_register})
        if (decision == Decision::allowed)
            decision = decide_items(query, area, true, 0, kLastItem, 0, deciders);
    return decision;
}

Decision AccessControl::decide_access(const Query& query, const wire::ItemAccess& access,
                                      Deciders& deciders) const {
    const unsigned end = access.start + access.count - 1U;
    const auto decision =
        decide_items(query, access.area, access.write, access.start, std::min(end, kLastItem), 0, deciders);
    if (decision != Decision::allowed || end <= kLastItem) return decision;
    return decide_items(query, access.area, access.write, 0, end - kLastItem - 1, 0, deciders);
}

// Items that this rule does not cover are decided by the following rules.
Decision AccessControl::decide_items(const Query& query, Area area, bool write, unsigned first, unsigned last,
                                     std::size_t rule, Deciders& deciders) const {
    for (; rule < rules_.size(); ++rule) {
        const AccessRule& candidate = rules_[rule];
        if ((candidate.area && *candidate.area != area) || !fits(candidate, query)) continue;
        const bool whole = !candidate.area || candidate.items.empty();
        bool any = whole;
        unsigned next = first;
        for (const AddressRange& range : candidate.items) {
            if (whole || range.last < first || range.first > last) continue;
            any = true;
            if (range.first > next) {
                const Decision rest =
                    decide_items(query, area, write, next, range.first - 1U, rule + 1, deciders);
                if (rest != Decision::allowed) return rest;
            }
            next = range.last + 1U;
        }
        if (!any) continue;
        deciders[rule] = true;
        const Decision decision = decision_of(candidate, write);
        if (decision != Decision::allowed || whole || next > last) return decision;
        first = next;
    }
    return Decision::denied;
}

Decision AccessControl::decide_whole(const Query& query, Deciders& deciders) const {
    for (std::size_t rule = 0; rule < rules_.size(); ++rule) {
        if (rules_[rule].area || !fits(rules_[rule], query)) continue;
        deciders[rule] = true;
        return decision_of(rules_[rule], query.writes);
    }
    return Decision::denied;
}

Decision AccessControl::decide(const Context& context, std::span<const UnitRange> units,
                               const wire::RequestView& request) {
    Deciders deciders;
    const Decision decision = decide_units(context, units, request, deciders);
    if (decision == Decision::allowed && !charge(context, deciders)) return Decision::too_fast;
    return decision;
}

Decision AccessControl::decide_again(const Context& context, std::span<const UnitRange> units,
                                     const wire::RequestView& request) const {
    Deciders deciders;
    return decide_units(context, units, request, deciders);
}

// Takes a token of each rule, or none.
bool AccessControl::charge(const Context& context, const Deciders& deciders) {
    if (buckets_.empty()) return true;
    const IpAddress peer = rate_owner(parse_peer(context.peer).value_or(IpAddress{}));
    const auto charged = [&](std::size_t rule) { return deciders[rule] && rules_[rule].rate; };
    for (std::size_t rule = 0; rule < rules_.size(); ++rule)
        if (charged(rule) &&
            bucket_of(context.time, peer, rule).tokens->next_admission(context.time) > context.time)
            return false;
    for (std::size_t rule = 0; rule < rules_.size(); ++rule)
        if (charged(rule)) (void)bucket_of(context.time, peer, rule).tokens->admit(context.time);
    return true;
}

// The peer's own bucket; else an empty one: an unused one, or that of the peer that was silent longest.
RateBucket& AccessControl::bucket_of(Instant t, const IpAddress& peer, std::size_t rule) {
    RateBucket* chosen = &buckets_.front();
    for (RateBucket& other : buckets_) {
        if (other.tokens && other.rule == rule && other.peer == peer) {
            other.seen = t;
            return other;
        }
        if (!chosen->tokens) continue;
        if (!other.tokens || other.seen < chosen->seen) chosen = &other;
    }
    *chosen = {.peer = peer,
               .rule = static_cast<std::uint32_t>(rule),
               .seen = t,
               .tokens = full_bucket(*rules_[rule].rate)};
    return *chosen;
}

Answer rejection(const Context& context, const wire::RequestView& request, AccessControl::Decision decision) {
    Answer answer;
    if (context.broadcast) return answer;
    answer.kind = Answer::Kind::response;
    refuse(answer, request,
           decision == Decision::too_fast ? wire::ExceptionCode::server_device_busy
                                          : wire::ExceptionCode::illegal_function);
    return answer;
}

}  // namespace takt::serve
