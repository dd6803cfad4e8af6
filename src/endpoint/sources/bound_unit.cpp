// Bound variables are sorted by area and start. A request finds its variables with a binary search that
// starts one longest variable before the request.
#include <algorithm>
#include <utility>

#include "takt/endpoint/bindings.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::endpoint {
namespace {

using wire::Area;
using wire::ExceptionCode;

constexpr unsigned kBitsInARegister = 16;

std::size_t index_of(Area area) {
    return static_cast<std::size_t>(area);
}

/// The value as a bool; nothing if it is neither a bool nor 0 or 1.
std::optional<bool> as_bool(const value::Value& value) {
    const auto converted = value::convert(DataType::boolean, false, value);
    return converted ? std::optional(std::get<bool>(*converted)) : std::nullopt;
}

}  // namespace

BoundUnit::BoundUnit(const model::ServerUnit& settings, serve::Unit& unit, const CheckValue& check,
                     const PassOn& pass, const PutOffAnswer& put_off)
    : unit_(unit), check_(check), pass_(pass), put_off_(put_off), alive_(std::make_shared<BoundUnit*>(this)) {
    for (const auto& binding : settings.bindings) add(binding, settings.variables[binding.variable]);
    for (std::size_t area = 0; area < bound_.size(); ++area) {
        std::ranges::stable_sort(bound_[area], {}, &Bound::start);
        for (const auto& bound : bound_[area]) longest_[area] = std::max(longest_[area], bound.count);
    }
}

BoundUnit::~BoundUnit() = default;

void BoundUnit::add(const model::Binding& binding, const model::Variable& variable) {
    if (!variable.used) return;
    Bound bound{.variable = &variable, .binding = &binding};
    bound.layout = value::layout_of(variable);
    bound.start = variable.start();
    bound.count = variable.items();
    Area area = variable.area;
    if (wire::is_bit_area(area)) {
        const auto& bits = unit_.banks.bits(area);
        bound.is_bit = !bits.overlay;
        if (bits.overlay) {
            const unsigned bit = bound.start - bits.first;
            area = bits.overlay->area;
            bound.start = static_cast<std::uint16_t>(bits.overlay->first + bit / kBitsInARegister);
            bound.layout.bit = static_cast<std::uint8_t>(bit % kBitsInARegister);
        }
    }
    bound_[index_of(area)].push_back(std::move(bound));
}

void BoundUnit::connect(const model::Binding& binding, std::unique_ptr<Feed> feed) {
    for (auto& area : bound_)
        for (auto& bound : area)
            if (bound.binding == &binding) {
                bound.feed = std::move(feed);
                return;
            }
}

void BoundUnit::find_sinks(const value::Store& store) {
    for (auto& area : bound_)
        for (auto& bound : area) {
            if (!bound.binding->sink) continue;
            const auto& sink = *bound.binding->sink;
            if (const auto* const variable = std::get_if<model::VariableSource>(&sink))
                bound.sink = store.find(variable->name);
            else if (const auto* const local = std::get_if<model::LocalSource>(&sink))
                bound.sink = store.find(local->name);
        }
}

/// The storage that a request touches. Bits of an overlay count as their registers.
BoundUnit::Items BoundUnit::stored(const serve::Access& access) const {
    Items items{access.area, access.start, access.start + access.count - 1U,
                access.function != wire::Function::mask_write_register};
    if (!wire::is_bit_area(access.area)) return items;
    const auto& bits = unit_.banks.bits(access.area);
    if (!bits.overlay) return items;
    items.area = bits.overlay->area;
    items.first = bits.overlay->first + (items.first - bits.first) / kBitsInARegister;
    items.last = bits.overlay->first + (items.last - bits.first) / kBitsInARegister;
    items.whole = false;
    return items;
}

/// Calls the function for each until one refuses.
template <class Each>
Refusal BoundUnit::each_touched(const Items& items, const Each& each) {
    auto& all = bound_[index_of(items.area)];
    const std::uint32_t longest = longest_[index_of(items.area)];
    const std::uint32_t from = items.first > longest ? items.first - longest : 0;
    auto at = std::ranges::lower_bound(all, from, {}, [](const Bound& b) { return std::uint32_t{b.start}; });
    for (; at != all.end() && at->start <= items.last; ++at) {
        if (at->start + at->count - 1U < items.first) continue;
        if (const auto refusal = each(*at)) return refusal;
    }
    return {};
}

std::optional<ExceptionCode> BoundUnit::before(const serve::Context& context, const serve::Access& access) {
    const Items items = stored(access);
    if (!access.write)
        return each_touched(items, [&](Bound& bound) {
            return bound.binding->source ? refresh(bound, context.time) : Refusal{};
        });
    return each_touched(items, [&](Bound& bound) -> Refusal {
        if (!bound.binding->sink) return ExceptionCode::illegal_data_address;
        if (!bound.binding->source) {
            bound.held = shown(bound);
            return {};
        }
        const auto refusal = refresh(bound, context.time);
        const bool whole =
            items.whole && bound.start >= items.first && bound.start + bound.count - 1U <= items.last;
        return whole ? Refusal{} : refusal;
    });
}

void BoundUnit::written(const serve::Context&, const serve::Access& access) {
    const Items items = stored(access);
    const auto refused = each_touched(items, [&](Bound& bound) {
        const auto value = shown(bound);
        return value::is_empty(value) ? Refusal{} : check_({*bound.binding->sink, bound.sink}, value);
    });
    each_touched(items, [&](Bound& bound) -> Refusal {
        if (const auto value = shown(bound); !value::is_empty(value)) pass(bound, value, refused);
        return {};
    });
}

Refusal BoundUnit::refresh(Bound& bound, Instant t) {
    constexpr auto kNotThere = ExceptionCode::gateway_target_failed_to_respond;
    if (!bound.feed) return kNotThere;
    const auto reading = bound.feed->read(t);
    if (!reading.fresh(t, bound.binding->max_age)) return kNotThere;
    if (bound.held_at && *reading.at <= *bound.held_at) return show(bound, bound.held);
    bound.held_at.reset();
    return show(bound, reading.value);
}

Refusal BoundUnit::show(Bound& bound, const value::Value& value) {
    auto& banks = unit_.banks;
    if (bound.is_bit) {
        const auto on = as_bool(value);
        if (!on) return ExceptionCode::server_device_failure;
        banks.set_bit(bound.variable->area, bound.start, *on);
        return {};
    }
    const auto encoded = value::encode(bound.layout, value);
    if (!encoded) return ExceptionCode::server_device_failure;
    const bool in_place = wire::is_bit_area(bound.variable->area);
    const Area area = in_place ? banks.bits(bound.variable->area).overlay->area : bound.variable->area;
    auto& bank = banks.registers(area);
    for (std::size_t i = 0; i < encoded->registers.size(); ++i) {
        const auto address = static_cast<std::uint16_t>(bound.start + i);
        const unsigned others = bank.get(address) & ~unsigned{value::register_mask(bound.layout)};
        bank.set(address, static_cast<std::uint16_t>(others | encoded->registers[i]));
    }
    return {};
}

/// The value in the bank; nothing if the registers hold no valid value.
value::Value BoundUnit::shown(const Bound& bound) const {
    const auto& banks = unit_.banks;
    value::Value found;
    if (bound.is_bit) {
        found.emplace<bool>(banks.bit(bound.variable->area, bound.start));
        return found;
    }
    const bool in_place = wire::is_bit_area(bound.variable->area);
    const Area area = in_place ? banks.bits(bound.variable->area).overlay->area : bound.variable->area;
    std::array<std::uint16_t, 125> registers{};
    for (std::size_t i = 0; i < bound.count; ++i)
        registers[i] = banks.registers(area).get(static_cast<std::uint16_t>(bound.start + i));
    if (auto value = value::decode(bound.layout, std::span(registers).first(bound.count)))
        found = *std::move(value);
    return found;
}

void BoundUnit::pass(Bound& bound, const value::Value& value, const Refusal& refused) {
    const auto passed = bound.binding->answer_at_once ? Passed{} : put_off_();
    const bool sourced = bound.binding->source.has_value();
    // A register was written for the sake of another bit: this bit is not passed on.
    if (sourced && bound.layout.bit && bound.feed) {
        const auto reading = bound.feed->read(line::now());
        if (reading.at && as_bool(reading.value) == as_bool(value) && !bound.held_at) {
            if (passed) passed({});
            return;
        }
    }
    const auto settle = [alive = std::weak_ptr(alive_), &bound, value, passed, sourced,
                         before = bound.held](const Refusal& refusal) {
        if (const auto unit = alive.lock()) {
            if (!refusal && sourced) {
                bound.held = value;
                bound.held_at = line::now();
            } else if (refusal && !sourced && !value::is_empty(before)) {
                (*unit)->show(bound, before);
            }
        }
        if (passed) passed(refusal);
    };
    if (refused) return settle(refused);
    pass_({*bound.binding->sink, bound.sink}, value, settle);
}

}  // namespace takt::endpoint
