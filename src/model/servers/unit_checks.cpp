#include "servers/unit_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "devices/addressing.hpp"
#include "takt/model/item_ranges.hpp"

namespace takt::model {
namespace {

constexpr unsigned kBitsInARegister = 16;
constexpr unsigned kRegisterValues = 65536;

const std::vector<ItemRange>& bank_of(const ServerUnit& unit, wire::Area area) {
    return unit.offered[static_cast<std::size_t>(area)];
}

/// Whether the limits allow this register value.
bool admits(const RegisterLimits& limits, std::uint16_t word) {
    const auto value = limits.least < 0 ? std::int32_t{static_cast<std::int16_t>(word)} : std::int32_t{word};
    return limits.least <= value && value <= limits.greatest;
}

/// Whether two limits overlap. Both are ranges of int16 or uint16, so an overlap contains an end of one of
/// them.
bool contradict(const RegisterLimits& a, const RegisterLimits& b) {
    const auto end_in = [](const RegisterLimits& one, const RegisterLimits& other) {
        return admits(other, static_cast<std::uint16_t>(one.least)) ||
               admits(other, static_cast<std::uint16_t>(one.greatest));
    };
    const bool zero = admits(a, 0) && admits(b, 0);
    return !zero && !end_in(a, b) && !end_in(b, a);
}

void report_bank(Interpretation& state, Rule rule, const SourceLocation& location, const std::string& path,
                 const ServerUnit& unit, wire::Area area, const ItemRange& items) {
    const auto& there = bank_of(unit, area);
    if (there.empty())
        return state.findings.add(Rule::bank_missing, location, path, std::to_string(items.first), {},
                                  {{"area", area_name(area)}});
    state.findings.add(rule, location, path, std::to_string(items.first), to_text(there),
                       {{"area", area_name(area)},
                        {"first", std::to_string(items.first)},
                        {"last", std::to_string(items.last)}});
}

void check_overlay(Interpretation& state, const ServerUnit& unit, wire::Area area, const std::string& path) {
    const auto& overlay = unit.overlays[static_cast<std::size_t>(area)];
    const auto& bits = bank_of(unit, area);
    if (!overlay || bits.empty()) return;
    for (const auto& range : bits) {
        const auto under = [&](unsigned item) {
            return overlay->first + (item - bits.front().first) / kBitsInARegister;
        };
        const ItemRange registers{
            static_cast<std::uint16_t>(under(range.first)),
            static_cast<std::uint16_t>(std::min(under(range.last), kRegisterValues - 1))};
        if (holds(bank_of(unit, overlay->area), registers)) continue;
        report_bank(state, Rule::bank_overlay_outside, overlay->location, path, unit, overlay->area,
                    registers);
        return;
    }
}

void check_limits(Interpretation& state, const ServerUnit& unit, const std::string& path) {
    for (std::size_t i = 0; i < unit.limits.size(); ++i) {
        const auto& limits = unit.limits[i];
        for (const auto& range : limits.registers)
            if (!holds(bank_of(unit, wire::Area::holding_register), range)) {
                report_bank(state, Rule::limits_outside, limits.location, path, unit,
                            wire::Area::holding_register, range);
                break;
            }
        for (std::size_t other = 0; other < i; ++other) {
            const auto& first = unit.limits[other];
            const auto both = without(limits.registers, without(limits.registers, first.registers));
            if (both.empty() || !contradict(limits, first)) continue;
            state.findings.add(Rule::limits_contradictory, limits.location, path,
                               std::to_string(limits.least) + ".." + std::to_string(limits.greatest), {},
                               {{"register", std::to_string(both.front().first)},
                                {"first", state.describe({first.location, path})}});
            break;
        }
    }
}

// A bank that cannot be written has nothing to retain.
void check_retained(Interpretation& state, const ServerUnit& unit, const std::string& path) {
    const auto& coils = unit.overlays[static_cast<std::size_t>(wire::Area::coil)];
    const auto& discrete = unit.overlays[static_cast<std::size_t>(wire::Area::discrete_input)];
    const bool inputs_written = coils && coils->area == wire::Area::input_register;
    const bool discrete_written =
        discrete && (discrete->area == wire::Area::holding_register || inputs_written);
    const auto check = [&](wire::Area area, bool written) {
        if (written || unit.retained[static_cast<std::size_t>(area)].empty()) return;
        state.findings.add(Rule::field_without_effect, unit.location, path, {}, {},
                           {{"key", "retain"}, {"condition", "area: " + area_name(area)}});
    };
    check(wire::Area::discrete_input, discrete_written);
    check(wire::Area::input_register, inputs_written);
}

/// The value of a variable of one whole register; nothing for other variables.
std::optional<std::uint16_t> register_value(const Variable& variable) {
    const bool whole =
        (variable.type == DataType::int16 || variable.type == DataType::uint16) && !variable.bit;
    if (!whole || !variable.default_value) return std::nullopt;
    const double raw = variable.scaled()
                           ? std::round((variable.default_value->number - variable.offset) / variable.scale)
                           : static_cast<double>(variable.default_value->integer);
    if (!(std::abs(raw) < kRegisterValues)) return std::nullopt;
    const auto word = static_cast<std::uint16_t>(static_cast<std::int32_t>(raw));
    return variable.order.high_byte_first ? word : static_cast<std::uint16_t>(word << 8 | word >> 8);
}

void check_default(Interpretation& state, const ServerUnit& unit, const Node& node, const std::string& path) {
    const Variable& variable = unit.variables.back();
    const auto value = register_value(variable);
    const Node* const given = node.find("default");
    if (!value || given == nullptr || variable.area != wire::Area::holding_register) return;
    const ItemRange item{variable.start(), variable.start()};
    for (const auto& limits : unit.limits)
        if (holds(limits.registers, item) && !admits(limits, *value))
            state.findings.add(Rule::variable_default_limits, given->location, path + ".default", given->text,
                               std::to_string(limits.least) + ".." + std::to_string(limits.greatest));
}

const Binding* binding_of(const ServerUnit& unit, std::size_t variable) {
    const auto found = std::ranges::find(unit.bindings, variable, &Binding::variable);
    return found != unit.bindings.end() && found->source ? &*found : nullptr;
}

bool share_items(const Variable& a, const Variable& b) {
    if (a.area != b.area || a.start() >= b.start() + b.items() || b.start() >= a.start() + a.items())
        return false;
    return !a.bit || !b.bit || a.bit == b.bit;
}

void check_sources(Interpretation& state, const ServerUnit& unit, const std::string& path) {
    const std::size_t last = unit.variables.size() - 1;
    const Variable& variable = unit.variables[last];
    if (!variable.used || binding_of(unit, last) == nullptr) return;
    for (const auto& binding : unit.bindings) {
        if (binding.variable == last || !binding.source) continue;
        const Variable& other = unit.variables[binding.variable];
        if (!other.used || other.name.empty() || !share_items(variable, other)) continue;
        state.findings.add(Rule::variable_bound_twice, variable.location, path, variable.name, {},
                           {{"other", other.name}});
        return;
    }
}

}  // namespace

std::string to_text(const std::vector<ItemRange>& ranges) {
    std::string text;
    for (const auto& range : ranges)
        text.append(text.empty() ? "" : ", ")
            .append(std::to_string(range.first) + ".." + std::to_string(range.last));
    return text;
}

void check_banks(Interpretation& state, const ServerUnit& unit, const std::string& path) {
    for (const auto area : {wire::Area::coil, wire::Area::discrete_input})
        check_overlay(state, unit, area, path + ".banks");
    check_limits(state, unit, path + ".limits");
    check_retained(state, unit, path + ".banks");
}

void check_served_variable(Interpretation& state, const ServerUnit& unit, const Node& node,
                           const std::string& path) {
    const Variable& variable = unit.variables.back();
    if (variable.name.empty()) return;
    const unsigned last = variable.start() + variable.items() - 1U;
    const ItemRange items{variable.start(), static_cast<std::uint16_t>(std::min(last, kRegisterValues - 1))};
    if (!holds(bank_of(unit, variable.area), items))
        report_bank(state, Rule::variable_outside_bank, variable.location, path, unit, variable.area, items);
    check_default(state, unit, node, path);
    check_sources(state, unit, path);
}

void check_overlaps(Interpretation& state, const ServerUnit& unit, const std::string& path) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < unit.variables.size(); ++i)
        if (unit.variables[i].used && !unit.variables[i].name.empty()) order.push_back(i);
    const auto position = [&](std::size_t i) {
        const Variable& variable = unit.variables[i];
        return std::tuple(variable.area, variable.start(), variable.bit.value_or(0), i);
    };
    std::ranges::sort(order, {}, position);
    // Of the whole items and of the bits: the variable that reaches furthest so far.
    std::array<const Variable*, 2> furthest{};
    std::array<std::size_t, 2> index{};
    for (const auto i : order) {
        const Variable& variable = unit.variables[i];
        const std::size_t kind = variable.bit ? 1 : 0;
        const auto* const other = furthest[kind];
        const auto end = [](const Variable& v) { return v.start() + v.items(); };
        if (other != nullptr && share_items(variable, *other)) {
            const auto later = std::max(i, index[kind]);
            const auto& name = unit.variables[std::min(i, index[kind])].name;
            if (binding_of(unit, i) == nullptr || binding_of(unit, index[kind]) == nullptr)  // else reported
                state.findings.add(Rule::variable_overlap, unit.variables[later].location,
                                   path + "[" + std::to_string(later) + "]", unit.variables[later].name, {},
                                   {{"other", name}});
        }
        if (other != nullptr && other->area == variable.area && end(*other) > end(variable)) continue;
        furthest[kind] = &variable;
        index[kind] = i;
    }
}

}  // namespace takt::model
