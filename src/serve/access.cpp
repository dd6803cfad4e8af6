// Evaluation of access rules, first match wins:
//   - a rule matches by peer, unit, function and area; a rule with items decides only those items, and the
//     remaining ones go on to the next rule;
//   - a request is allowed if each of its items is; items that no rule decides are denied;
//   - a request without items (function 8, for example) skips the rules that name an area;
//   - the first rule that decided some item limits the rate: a token bucket per peer, counted in nanoseconds.
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

/// The items whose address is at `at` and whose count follows; none if the request is too short.
void touch(RequestScope& scope, Bytes request, std::size_t at, Area area, bool write, bool counted = true) {
    scope.writes = scope.writes || write;
    if (request.size() < at + (counted ? 4 : 2)) return;
    const unsigned first = word(request, at);
    const unsigned count = counted ? std::max<unsigned>(word(request, at + 2), 1) : 1;
    scope.touched[scope.touches++] = {area, static_cast<std::uint16_t>(first),
                                      static_cast<std::uint16_t>(std::min(first + count - 1, 0xFFFFU)),
                                      write};
}

Decision decision_of(const AccessRule& rule, bool writes) {
    switch (rule.permission) {
        case Permission::allow: return Decision::allowed;
        case Permission::read_only: return writes ? Decision::read_only : Decision::allowed;
        case Permission::deny: break;
    }
    return Decision::denied;
}

/// The owner of a rate bucket: an IPv4 address or an IPv6 /64, because a client controls all addresses of its
/// network.
IpAddress holder(const std::optional<IpAddress>& peer) {
    if (!peer || peer->is_ipv4()) return peer.value_or(IpAddress{});
    IpAddress network = *peer;
    std::fill(network.bytes.begin() + 8, network.bytes.end(), std::uint8_t{0});
    return network;
}

TokenBucket full_bucket(const RateLimit& rate) {
    constexpr Duration kSecond = std::chrono::seconds(1);
    const auto bucket = TokenBucket::create(rate.burst, std::max(kSecond / rate.per_second, Duration(1)));
    TAKT_ASSERT(bucket);
    return *bucket;
}

}  // namespace

RequestScope scope_of(Bytes request) {
    RequestScope scope;
    scope.function = request[0];
    switch (static_cast<Function>(request[0])) {
        case Function::read_coils: touch(scope, request, 1, Area::coil, false); break;
        case Function::read_discrete_inputs: touch(scope, request, 1, Area::discrete_input, false); break;
        case Function::read_holding_registers: touch(scope, request, 1, Area::holding_register, false); break;
        case Function::read_input_registers: touch(scope, request, 1, Area::input_register, false); break;
        case Function::read_fifo_queue: touch(scope, request, 1, Area::holding_register, false, false); break;
        case Function::write_single_coil: touch(scope, request, 1, Area::coil, true, false); break;
        case Function::write_multiple_coils: touch(scope, request, 1, Area::coil, true); break;
        case Function::write_single_register:
        case Function::mask_write_register:
            touch(scope, request, 1, Area::holding_register, true, false);
            break;
        case Function::write_multiple_registers:
            touch(scope, request, 1, Area::holding_register, true);
            break;
        case Function::read_write_multiple_registers:
            touch(scope, request, 1, Area::holding_register, false);
            touch(scope, request, 5, Area::holding_register, true);
            break;
        default: scope.writes = wire::effect(request) == wire::Effect::write; break;
    }
    return scope;
}

struct AccessControl::Query {
    std::optional<IpAddress> peer;
    Instant time;
    UnitId unit;
    const RequestScope& scope;
};

void AccessControl::set_rules(std::span<const AccessRule> rules) {
    rules_ = rules;
    std::ranges::fill(buckets_, RateBucket{});
}

bool AccessControl::fits(const AccessRule& rule, const Query& query) const {
    if (!rule.functions.has(query.scope.function)) return false;
    const auto holds = [&](const UnitRange& range) {
        return range.first <= query.unit.value && query.unit.value <= range.last;
    };
    if (!rule.units.empty() && std::ranges::none_of(rule.units, holds)) return false;
    if (rule.every_peer) return true;
    if (!query.peer) return rule.serial;
    return std::ranges::any_of(rule.networks,
                               [&](const Network& network) { return network.contains(*query.peer); });
}

// Items that this rule does not cover are decided by the following rules.
Decision AccessControl::decide_items(const Query& query, const Touched& touched, unsigned first,
                                     unsigned last, std::size_t rule, std::size_t& decider) const {
    for (; rule < rules_.size(); ++rule) {
        const AccessRule& candidate = rules_[rule];
        if ((candidate.area && *candidate.area != touched.area) || !fits(candidate, query)) continue;
        const bool whole = !candidate.area || candidate.items.empty();
        bool any = whole;
        unsigned next = first;
        for (const AddressRange& range : candidate.items) {
            if (whole || range.last < first || range.first > last) continue;
            any = true;
            if (range.first > next) {
                const Decision rest = decide_items(query, touched, next, range.first - 1U, rule + 1, decider);
                if (rest != Decision::allowed) return rest;
            }
            next = range.last + 1U;
        }
        if (!any) continue;
        decider = std::min(decider, rule);
        const Decision decision = decision_of(candidate, touched.write);
        if (decision != Decision::allowed || whole || next > last) return decision;
        first = next;
    }
    return Decision::denied;
}

Decision AccessControl::decide_whole(const Query& query, std::size_t& decider) const {
    for (std::size_t rule = 0; rule < rules_.size(); ++rule) {
        if (rules_[rule].area || !fits(rules_[rule], query)) continue;
        decider = rule;
        return decision_of(rules_[rule], query.scope.writes);
    }
    return Decision::denied;
}

Decision AccessControl::decide(const Context& context, UnitId unit, const RequestScope& scope) {
    if (rules_.empty()) return Decision::allowed;
    const Query query{parse_peer(context.peer), context.time, unit, scope};
    std::size_t decider = rules_.size();
    Decision decision = Decision::allowed;
    for (std::size_t i = 0; i < scope.touches && decision == Decision::allowed; ++i)
        decision =
            decide_items(query, scope.touched[i], scope.touched[i].first, scope.touched[i].last, 0, decider);
    if (scope.touches == 0) decision = decide_whole(query, decider);
    if (decision == Decision::allowed && !take_token(query, decider)) return Decision::too_fast;
    return decision;
}

bool AccessControl::take_token(const Query& query, std::size_t rule) {
    if (rule >= rules_.size() || !rules_[rule].rate || buckets_.empty()) return true;
    RateBucket& bucket = bucket_of(holder(query.peer), static_cast<std::uint32_t>(rule));
    bucket.seen = query.time;
    if (!bucket.tokens) bucket.tokens = full_bucket(*rules_[rule].rate);
    return bucket.tokens->admit(query.time);
}

// The peer's own bucket; else an empty one: an unused one, or that of the peer that was silent longest.
RateBucket& AccessControl::bucket_of(const IpAddress& peer, std::uint32_t rule) {
    RateBucket* chosen = &buckets_.front();
    for (RateBucket& other : buckets_) {
        if (other.tokens && other.rule == rule && other.peer == peer) return other;
        if (!chosen->tokens) continue;
        if (!other.tokens || other.seen < chosen->seen) chosen = &other;
    }
    *chosen = {.peer = peer, .rule = rule};
    return *chosen;
}

Decision AccessControl::admit(const Context& context, std::span<const UnitId> units, bool served,
                              const RequestScope& scope) {
    if (context.broadcast) {
        for (const UnitId unit : units)
            if (const auto decision = decide(context, unit, scope); decision != Decision::allowed)
                return decision;
        return Decision::allowed;
    }
    const bool to_first = (context.unit.value == 0 || context.unit.value == 255) && !units.empty() && !served;
    return decide(context, to_first ? units.front() : context.unit, scope);
}

Answer rejection(const Context& context, Bytes request, AccessControl::Decision decision) {
    Answer answer;
    if (context.broadcast) return answer;
    answer.kind = Answer::Kind::response;
    refuse(answer, request[0],
           decision == Decision::too_fast ? wire::ExceptionCode::server_device_busy
                                          : wire::ExceptionCode::illegal_function);
    return answer;
}

}  // namespace takt::serve
