#include "blank_unit.hpp"

#include <algorithm>
#include <utility>

namespace takt::endpoint {
namespace {

/// Sorted, without overlaps.
std::vector<serve::AddressRange> in_order(std::vector<serve::AddressRange> ranges) {
    std::ranges::sort(ranges, {}, &serve::AddressRange::first);
    std::vector<serve::AddressRange> merged;
    for (const auto range : ranges) {
        if (!merged.empty() && range.first <= merged.back().last)
            merged.back().last = std::max(merged.back().last, range.last);
        else
            merged.push_back(range);
    }
    return merged;
}

}  // namespace

RangesByArea by_area(const std::vector<BlankSpec::Range>& ranges) {
    RangesByArea areas;
    for (const auto& [area, addresses] : ranges) areas[static_cast<std::size_t>(area)].push_back(addresses);
    for (auto& area : areas) area = in_order(std::move(area));
    return areas;
}

BlankUnit::BlankUnit(const BlankSpec& spec)
    : spec_(spec),
      devices_(spec.unit, spec.fill),
      offered_(by_area(spec_.ranges)),
      read_only_(by_area(spec_.read_only)),
      functions_({spec_.may_restart, spec_.may_listen_only, spec_.status_coils}) {
    for (const auto& [addresses, least, greatest] : spec_.limits)
        limits_[static_cast<std::size_t>(wire::Area::holding_register)].push_back(
            {addresses, least, greatest});
    identify();
    fill_files();
    for (const auto& [address, values] : spec_.fifos) functions_.add_fifo(address, values);
    lay_out(devices_.units().front());
}

void BlankUnit::lay_out(serve::Unit& unit) {
    unit.extensions = functions_.extensions(true);
    for (const wire::Area area : {wire::Area::coil, wire::Area::discrete_input}) {
        unit.banks.bits(area).offered = offered_[static_cast<std::size_t>(area)];
        unit.banks.bits(area).read_only = read_only_[static_cast<std::size_t>(area)];
    }
    for (const wire::Area area : {wire::Area::input_register, wire::Area::holding_register}) {
        unit.banks.registers(area).offered = offered_[static_cast<std::size_t>(area)];
        unit.banks.registers(area).read_only = read_only_[static_cast<std::size_t>(area)];
        unit.banks.registers(area).limits = limits_[static_cast<std::size_t>(area)];
    }
    if (spec_.overlay) unit.banks.coils.overlay = serve::BitOverlay{};
}

void BlankUnit::identify() {
    if (spec_.objects.empty()) spec_.objects = {{0, "Takt"}, {1, "takt serve"}, {2, "1"}};
    std::ranges::stable_sort(spec_.objects, {}, &BlankSpec::Object::id);
    const auto same = [](const auto& one, const auto& other) { return one.id == other.id; };
    const auto surplus = std::ranges::unique(spec_.objects, same);  // of equal ids the first counts
    spec_.objects.erase(surplus.begin(), surplus.end());
    for (const auto& [id, text] : spec_.objects) functions_.add_object(id, text);
    functions_.set_server_id(devices_.units().front().id, spec_.server_id);
}

void BlankUnit::fill_files() {
    for (const auto& [number, count] : spec_.files) {
        const auto records = functions_.add_file(number, count);
        for (std::size_t i = 0; spec_.fill == sim::Fill::ramp && i < records.size(); ++i)
            records[i] = static_cast<std::uint16_t>(i);
    }
}

}  // namespace takt::endpoint
