#include "takt/console/served_devices.hpp"

#include <utility>

#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"

namespace takt::console {
namespace {

value::Layout layout_of(const model::Variable& variable) {
    return {.type = variable.type,
            .order = variable.order,
            .registers = variable.registers,
            .bit = is_bit_area(variable.area) ? std::nullopt : variable.bit,
            .scale = variable.scale,
            .offset = variable.offset};
}

/// The items of a variable that has the value; a bit of a register keeps the others.
Result<std::vector<std::uint16_t>> items_of(const model::Variable& variable, const value::Value& value,
                                            const std::vector<std::uint16_t>& before) {
    if (is_bit_area(variable.area)) return std::vector{std::uint16_t{std::get<bool>(value)}};
    const auto layout = layout_of(variable);
    TAKT_TRY(const auto encoded, value::encode(layout, value));
    std::vector<std::uint16_t> registers(encoded.registers.begin(), encoded.registers.end());
    if (!layout.bit) return registers;
    const auto mask = value::register_mask(layout);
    registers[0] = static_cast<std::uint16_t>((before[0] & ~mask) | (registers[0] & mask));
    return registers;
}

}  // namespace

void ServedDevices::add(const model::Line& line, std::size_t index, sim::Device& device) {
    devices_.push_back({&line, &line.devices[index], &device});
}

Result<ServedDevices::Found> ServedDevices::find(const std::string& name) const {
    for (const auto& served : devices_)
        for (const auto& variable : served.config->variables)
            if (variable.name == name) return Found{&served, &variable};
    return fail(Code::not_found, name);
}

Result<sim::FaultScope> ServedDevices::scope_of(const std::string& name) const {
    std::vector<const Served*> named;
    std::string full_names;
    for (const auto& served : devices_) {
        const auto full = served.line->name + '/' + served.config->name;
        if (served.config->name != name && full != name) continue;
        named.push_back(&served);
        full_names += (full_names.empty() ? "" : ", ") + full;
    }
    if (named.size() > 1) return fail(Code::syntax, value::beside_allowed(name, full_names));
    if (named.size() == 1)
        return sim::FaultScope{name, named[0]->line->name, named[0]->config->address, std::nullopt};
    TAKT_TRY(const auto found, find(name));
    const auto& variable = *found.variable;
    return sim::FaultScope{name, found.served->line->name, found.served->config->address,
                           sim::FaultScope::Items{variable.area, variable.start(), variable.items()}};
}

Result<void> ServedDevices::set(Instant t, const std::string& name, const std::string& text) {
    TAKT_TRY(const auto found, find(name));
    const auto& variable = *found.variable;
    TAKT_TRY(const auto value, value::parse(variable.type, variable.scaled(), text));
    const auto before = found.served->device->content(t, variable.area, variable.start(), variable.items());
    if (!before) return fail(Code::not_found, name);
    TAKT_TRY(const auto items, items_of(variable, value, *before));
    if (!found.served->device->change(t, variable.area, variable.start(), items))
        return fail(Code::not_found, name);
    return {};
}

Result<ServedDevices::Reading> ServedDevices::get(Instant t, const std::string& name) const {
    TAKT_TRY(const auto found, find(name));
    const auto& variable = *found.variable;
    const auto items = found.served->device->content(t, variable.area, variable.start(), variable.items());
    if (!items) return fail(Code::not_found, name);
    if (is_bit_area(variable.area)) return Reading{&variable, items->front() != 0};
    TAKT_TRY(auto value, value::decode(layout_of(variable), *items));
    return Reading{&variable, std::move(value)};
}

}  // namespace takt::console
