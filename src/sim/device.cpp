// Values move only when a master accesses them: before() writes the current values of the touched items into
// the banks, which serve::Server then reads. So a device costs nothing between requests, and the values
// depend on the time of the access alone. A written or changed item is held: from then on it keeps its value.
//
// The banks of an area begin at its first variable. `offered` has the ranges that exist: those of the
// variables, joined over gaps that the project allows to read.
#include "takt/sim/device.hpp"

#include <algorithm>
#include <type_traits>

#include "takt/value/codec.hpp"

namespace takt::sim {
namespace {

using wire::Area;

constexpr std::array kAreas{Area::coil, Area::discrete_input, Area::input_register, Area::holding_register};
constexpr unsigned kAllAddresses = 65536;

bool overlap(std::uint32_t a, std::uint32_t a_count, std::uint32_t b, std::uint32_t b_count) {
    return a < b + b_count && b < a + a_count;
}

/// Whether the project lets the device answer the items between two of its variables.
bool has_gap(const model::Device& device, Area area, unsigned first, unsigned last) {
    if (device.gaps != model::Gaps::always) return false;
    const auto index = static_cast<std::size_t>(area);
    const auto& readable = device.readable[index];
    const auto covers = [=](const model::ItemRange& range) {
        return range.first <= first && last <= range.last;
    };
    const auto touches = [=](const model::ItemRange& range) {
        return range.first <= last && first <= range.last;
    };
    return (readable.empty() || std::ranges::any_of(readable, covers)) &&
           std::ranges::none_of(device.no_read[index], touches);
}

/// @param value  a number or a bool
double number_of(const value::Value& value) {
    return std::visit(
        [](const auto& its) -> double {
            if constexpr (std::is_arithmetic_v<std::decay_t<decltype(its)>>) return static_cast<double>(its);
            return 0;
        },
        value);
}

}  // namespace

Device::Device(const model::Device& device, bool moving)
    : name_(device.name), address_(device.address), moving_(moving) {
    names_.reserve(device.variables.size());
    for (const model::Variable& variable : device.variables) {
        names_.push_back(variable.name);
        const bool bit_area = wire::is_bit_area(variable.area);
        of(variable.area)
            .variables.push_back({variable.start(), variable.items(), Pattern(variable.type, names_.back()),
                                  variable.type, variable.order, bit_area ? std::nullopt : variable.bit,
                                  !moving, names_.back(), variable.scale, variable.offset});
    }
    for (const Area area : kAreas) lay_out(device, area);
}

Device::Device(UnitId unit, Fill how) : address_(unit), fill_(how) {
    fill(how);
}

void Device::lay_out(const model::Device& device, Area area) {
    AreaData& data = of(area);
    if (data.variables.empty()) return;
    std::ranges::sort(data.variables, {}, &Variable::start);
    const std::uint16_t first = data.variables.front().start;
    for (const Variable& variable : data.variables) {
        const auto last =
            static_cast<std::uint16_t>(std::min<unsigned>(variable.start + variable.count - 1U, 0xFFFF));
        const bool begins = data.offered.empty() ||
                            (variable.start > data.offered.back().last + 1 &&
                             !has_gap(device, area, data.offered.back().last + 1U, variable.start - 1U));
        if (begins)
            data.offered.push_back({variable.start, last});
        else
            data.offered.back().last = std::max(data.offered.back().last, last);
        data.longest = std::max(data.longest, variable.count);
    }
    data.count = data.offered.back().last - first + 1U;
    if (wire::is_bit_area(area))
        data.bits.resize((data.count + 7) / 8);
    else
        data.registers.resize(data.count);
}

void Device::fill(Fill how) {
    Content content(how);
    for (const Area area : kAreas) {
        AreaData& data = of(area);
        data.count = kAllAddresses;
        const bool bits = wire::is_bit_area(area);
        data.bits.assign(bits ? kAllAddresses / 8 : 0, 0);
        data.registers.assign(bits ? 0 : kAllAddresses, 0);
        for (unsigned i = 0; i < kAllAddresses; ++i) {
            const auto item = content.item(i);
            if (bits)
                data.bits[i / 8] |= static_cast<std::uint8_t>((item & 1U) << i % 8);
            else
                data.registers[i] = item;
        }
    }
}

serve::Unit Device::unit() {
    return {address_,
            {bit_bank(Area::coil), bit_bank(Area::discrete_input), register_bank(Area::input_register),
             register_bank(Area::holding_register)},
            this};
}

serve::BitBank Device::bit_bank(Area area) {
    AreaData& data = of(area);
    const std::uint16_t first = data.offered.empty() ? std::uint16_t{0} : data.offered.front().first;
    return {first, data.count, data.bits, data.offered, {}};
}

serve::RegisterBank Device::register_bank(Area area) {
    AreaData& data = of(area);
    const std::uint16_t first = data.offered.empty() ? std::uint16_t{0} : data.offered.front().first;
    return {first, data.registers, data.offered, {}};
}

std::optional<wire::ExceptionCode> Device::before(const serve::Context& context,
                                                  const serve::Access& access) {
    if (behaviour.dead) return wire::ExceptionCode::server_device_failure;
    if (behaviour.refuses_all) return behaviour.refuses_all;
    for (const Behaviour::Refusal& refusal : behaviour.refusals)
        if (refusal.area == access.area &&
            overlap(refusal.addresses.first, refusal.addresses.last - refusal.addresses.first + 1U,
                    access.start, access.count))
            return refusal.code;
    if (source_) {
        follow_source(access, context.time);
        return {};
    }
    for (const Variable& variable : touching(access.area, access.start, access.count))
        if (!variable.held) refresh(access.area, variable, context.time);
    return {};
}

void Device::written(const serve::Context& context, const serve::Access& access) {
    hold(access.area, access.start, access.count);
    if (model_)
        for (const Variable& variable : touching(access.area, access.start, access.count))
            tell_model(access.area, variable, context.time);
    if (!observer_) return;
    observer_->on_write({context.time, address_, access.area, access.start,
                         items(access.area, access.start, access.count), context.broadcast});
}

void Device::hold(Area area, std::uint16_t start, std::uint16_t count) {
    AreaData& data = of(area);
    data.held.resize(data.count);
    const std::size_t first = data.offered.empty() ? 0 : data.offered.front().first;
    for (std::size_t i = 0; i < count; ++i) data.held[start - first + i] = true;
    for (Variable& variable : touching(area, start, count))
        variable.held = variable.held || overlap(variable.start, variable.count, start, count);
}

std::span<const std::uint16_t> Device::items(Area area, std::uint16_t start, std::uint16_t count) {
    reported_.clear();
    for (std::uint32_t address = start; address < std::uint32_t{start} + count; ++address) {
        const auto one = static_cast<std::uint16_t>(address);
        reported_.push_back(wire::is_bit_area(area) ? std::uint16_t{bit_bank(area).get(one)}
                                                    : register_bank(area).get(one));
    }
    return reported_;
}

void Device::tell_change(Instant t, Area area, std::uint16_t start, std::uint16_t count) {
    if (observer_) observer_->on_change({t, address_, area, start, items(area, start, count), false});
}

bool Device::change(Instant t, Area area, std::uint16_t start, std::span<const std::uint16_t> values) {
    const auto count = static_cast<std::uint16_t>(values.size());
    const bool bits = wire::is_bit_area(area);
    if (values.empty() || values.size() > kAllAddresses - 1) return false;
    if (!(bits ? serve::readable(bit_bank(area), start, count)
               : serve::readable(register_bank(area), start, count)))
        return false;
    for (std::uint16_t i = 0; i < count; ++i) {
        const auto address = static_cast<std::uint16_t>(start + i);
        if (bits)
            bit_bank(area).set(address, values[i] != 0);
        else
            register_bank(area).set(address, values[i]);
    }
    hold(area, start, count);
    tell_change(t, area, start, count);
    return true;
}

std::optional<std::vector<std::uint16_t>> Device::content(Instant t, Area area, std::uint16_t start,
                                                          std::uint16_t count) {
    if (!(wire::is_bit_area(area) ? serve::readable(bit_bank(area), start, count)
                                  : serve::readable(register_bank(area), start, count)))
        return std::nullopt;
    for (const Variable& variable : touching(area, start, count))
        if (!variable.held) refresh(area, variable, t);
    const auto values = items(area, start, count);
    return std::vector(values.begin(), values.end());
}

void Device::forget(Instant t) {
    if (std::ranges::all_of(kAreas, [this](Area area) { return of(area).variables.empty(); })) fill(fill_);
    for (const Area area : kAreas) {
        AreaData& data = of(area);
        if (!data.variables.empty()) {
            std::ranges::fill(data.registers, std::uint16_t{0});
            std::ranges::fill(data.bits, std::uint8_t{0});
        }
        data.held.clear();
        for (Variable& variable : data.variables) variable.held = !moving_;
        for (const serve::AddressRange& range : data.offered)
            tell_change(t, area, range.first, static_cast<std::uint16_t>(range.last - range.first + 1));
    }
}

// The search starts before the range by the length of the longest variable, because a variable may begin
// before it.
std::span<Device::Variable> Device::touching(Area area, std::uint16_t start, std::uint16_t count) {
    AreaData& data = of(area);
    const auto begins_before = [](unsigned address) {
        return [address](const Variable& variable) { return variable.start < address; };
    };
    const unsigned earliest = start >= data.longest ? start - data.longest + 1U : 0U;
    const auto first = std::ranges::partition_point(data.variables, begins_before(earliest));
    const auto last = std::ranges::partition_point(data.variables, begins_before(start + unsigned{count}));
    return {first, last};
}

void Device::follow_source(const serve::Access& access, Instant t) {
    AreaData& data = of(access.area);
    const std::size_t first = data.offered.empty() ? 0 : data.offered.front().first;
    for (std::size_t i = 0; i < access.count; ++i) {
        const auto address = static_cast<std::uint16_t>(access.start + i);
        if (address - first < data.held.size() && data.held[address - first]) continue;
        const std::uint16_t item = source_->item(address_, access.area, address, t);
        if (wire::is_bit_area(access.area))
            bit_bank(access.area).set(address, (item & 1) != 0);
        else
            register_bank(access.area).set(address, item);
    }
}

value::Layout Device::layout_of(const Variable& variable) {
    value::Layout layout;
    layout.type = variable.type;
    layout.order = variable.order;
    layout.registers = variable.count;
    layout.bit = variable.bit;
    return layout;
}

/// @param layout  gets the scale of the value
value::Value Device::now(const Variable& variable, value::Layout& layout, Instant t) const {
    const auto number = model_ ? model_->value(variable.name, t) : std::nullopt;
    if (!number) return variable.pattern.at(t);
    if (variable.type == DataType::boolean) return *number != 0;
    layout.scale = variable.scale;
    layout.offset = variable.offset;
    return *number;
}

void Device::tell_model(Area area, const Variable& variable, Instant t) {
    if (variable.type == DataType::string) return;
    if (wire::is_bit_area(area))
        return model_->on_written(variable.name, bit_bank(area).get(variable.start) ? 1 : 0, t);
    auto layout = layout_of(variable);
    layout.scale = variable.scale;
    layout.offset = variable.offset;
    const auto written = value::decode(layout, items(area, variable.start, variable.count));
    if (written) model_->on_written(variable.name, number_of(*written), t);
}

void Device::refresh(Area area, const Variable& variable, Instant t) {
    auto layout = layout_of(variable);
    value::Value now = this->now(variable, layout, t);
    if (auto* text = std::get_if<std::string>(&now))
        text->resize(std::min(text->size(), std::size_t{2} * variable.count));
    if (wire::is_bit_area(area)) {
        const bool before = bit_bank(area).get(variable.start);
        bit_bank(area).set(variable.start, std::get<bool>(now));
        if (before != std::get<bool>(now)) tell_change(t, area, variable.start, 1);
        return;
    }
    const auto encoded = value::encode(layout, now);
    if (!encoded) return;
    serve::RegisterBank bank = register_bank(area);
    const unsigned mask = value::register_mask(layout);
    bool changed = false;
    for (std::size_t i = 0; i < encoded->registers.size(); ++i) {
        const auto address = static_cast<std::uint16_t>(variable.start + i);
        const unsigned kept = bank.get(address) & ~mask;
        const auto value = static_cast<std::uint16_t>(kept | (encoded->registers[i] & mask));
        changed = changed || bank.get(address) != value;
        bank.set(address, value);
    }
    if (changed) tell_change(t, area, variable.start, variable.count);
}

}  // namespace takt::sim
