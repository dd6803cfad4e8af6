#include "tables/row_devices.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "takt/file/table.hpp"
#include "yaml/nodes.hpp"

namespace takt::file {

using model::Node;

void name_devices(std::vector<Node>& rows, const std::string& base) {
    std::set<std::string> addresses;
    for (const auto& row : rows) {
        if (row.find(kDeviceColumn) != nullptr) return;
        if (const auto address = text_of(row, kUnitAddressColumn); !address.empty())
            addresses.insert(address);
    }
    if (addresses.size() < 2) return;
    for (auto& row : rows)
        if (const auto* const cell = row.find(kUnitAddressColumn))
            set(row, kDeviceColumn, scalar(base + ' ' + cell->text, cell->location));
}

void qualify_names(std::vector<NamedVariables> devices, const std::set<std::string>& taken,
                   Reporter& reporter) {
    // The first device, and whether others follow. The names that are taken are those of another one.
    std::map<std::string, std::pair<std::size_t, bool>> owners;
    for (const auto& name : taken) owners.try_emplace(name, devices.size(), false);
    std::map<std::string, std::size_t> namesakes;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        ++namesakes[devices[i].device];
        for (const auto& row : devices[i].variables->items) {
            const auto [at, added] = owners.try_emplace(text_of(row, "name"), i, false);
            if (!added && at->second.first != i) at->second.second = true;
        }
    }
    for (auto& its : devices)
        if (namesakes[its.device] > 1) its.device += ' ' + its.address;
    owners.erase("");
    std::size_t count = 0;
    const Node* first = nullptr;
    std::string changed;
    for (const auto& [device, address, variables] : devices)
        for (auto& row : variables->items)
            for (auto& [key, cell] : row.entries) {
                if (key.text != "name") continue;
                const auto owner = owners.find(cell.text);
                if (owner == owners.end() || !owner->second.second) continue;
                if (++count == 1) {
                    first = &cell;
                    changed = cell.text;
                }
                cell.text = device + '.' + cell.text;
            }
    if (first != nullptr)
        reporter.warning(
            "file.convert.names_qualified", first->location,
            {.value = changed, .arguments = {{"name", first->text}, {"count", std::to_string(count)}}});
}

}  // namespace takt::file
