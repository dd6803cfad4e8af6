// The storage of a unit. A bank that is offered in several ranges is dense: its values are stored without the
// gaps between them, in the order of the ranges.
#include "stored_units.hpp"

#include "takt/value/codec.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::endpoint {
namespace {

using wire::Area;

constexpr std::array kAreas{Area::coil, Area::discrete_input, Area::input_register, Area::holding_register};

std::vector<serve::AddressRange> ranges_of(const std::vector<model::ItemRange>& ranges) {
    std::vector<serve::AddressRange> result;
    for (const auto [first, last] : ranges) result.push_back({first, last});
    return result;
}

}  // namespace

StoredUnit::StoredUnit(const model::ServerUnit& unit, sim::Fill how)
    : functions_({unit.may_restart, unit.may_listen_only, unit.exception_coils}) {
    sim::Content content(how);
    lay_out(unit);
    fill(content);
    add_functions(unit, content);
    unit_.id = unit.address;
    unit_.extensions = functions_.extensions();
    for (const auto& variable : unit.variables)
        if (variable.used && variable.default_value) put(variable);
}

void StoredUnit::lay_out(const model::ServerUnit& unit) {
    for (const Area area : kAreas) {
        const auto index = static_cast<std::size_t>(area);
        Bank& bank = banks_[index];
        bank.offered = ranges_of(unit.offered[index]);
        bank.read_only = ranges_of(unit.read_only[index]);
        for (const auto& range : bank.offered) bank.count += range.last - range.first + 1U;
        if (area == Area::holding_register)
            for (const auto& limits : unit.limits)
                for (const auto& range : ranges_of(limits.registers))
                    bank.limits.push_back({range, limits.least, limits.greatest});
        if (!wire::is_bit_area(area)) {
            bank.registers.resize(bank.count);
            unit_.banks.registers(area) = {.values = bank.registers,
                                           .offered = bank.offered,
                                           .read_only = bank.read_only,
                                           .limits = bank.limits,
                                           .dense = true};
            continue;
        }
        serve::BitBank& bits = unit_.banks.bits(area);
        bits = {.offered = bank.offered, .read_only = bank.read_only};
        if (const auto& overlay = unit.overlays[index]) {
            // The first bit of the bank is the lowest of the first register.
            bits.first = bank.offered.empty() ? std::uint16_t{0} : bank.offered.front().first;
            bits.count = bank.offered.empty() ? 0U : bank.offered.back().last - bits.first + 1U;
            bits.overlay = serve::BitOverlay{overlay->area, overlay->first};
        } else {
            bank.bits.resize((bank.count + 7) / 8);
            bits.count = bank.count;
            bits.packed = bank.bits;
            bits.dense = true;
        }
    }
}

void StoredUnit::fill(sim::Content& content) {
    for (Bank& bank : banks_) {
        std::size_t index = 0;
        for (const auto [first, last] : bank.offered)
            for (unsigned address = first; address <= last; ++address, ++index) {
                const auto item = content.item(address);
                if (index < bank.registers.size()) bank.registers[index] = item;
                if (index / 8 < bank.bits.size())
                    bank.bits[index / 8] |= static_cast<std::uint8_t>((item & 1U) << index % 8);
            }
    }
}

void StoredUnit::add_functions(const model::ServerUnit& unit, sim::Content& content) {
    for (const auto& [id, text] : unit.identification) functions_.add_object(id, text);
    functions_.set_server_id(unit.address, unit.server_id);
    for (const auto& file : unit.files) {
        unsigned number = 0;
        for (auto& record : functions_.add_file(file.number, file.records, file.read_only))
            record = content.item(number++);
    }
    for (const auto& [address, values] : unit.fifos) functions_.add_fifo(address, values);
}

void StoredUnit::put(const model::Variable& variable) {
    const auto value = value::to_value(variable.type, variable.scaled(), *variable.default_value);
    if (wire::is_bit_area(variable.area))
        return unit_.banks.set_bit(variable.area, variable.start(), variable.default_value->integer != 0);
    const auto layout = value::layout_of(variable);
    const auto encoded = value::encode(layout, value);
    if (!encoded) return;  // the project was checked: only a scaled value that fits no register
    serve::RegisterBank& bank = unit_.banks.registers(variable.area);
    for (std::size_t i = 0; i < encoded->registers.size(); ++i) {
        const auto address = static_cast<std::uint16_t>(variable.start() + i);
        const unsigned kept = bank.get(address) & ~value::register_mask(layout);  // neighbours of a bit
        bank.set(address, static_cast<std::uint16_t>(kept | encoded->registers[i]));
    }
}

StoredUnits::StoredUnits(std::span<const model::ServerUnit> units, sim::Fill fill) {
    for (const auto& unit : units) {
        stored_.push_back(std::make_unique<StoredUnit>(unit, fill));
        units_.push_back(stored_.back()->unit());
    }
    server_ = serve::Server(units_);
}

}  // namespace takt::endpoint
