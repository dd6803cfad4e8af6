#include "line/line_match.hpp"

#include <algorithm>
#include <map>
#include <string_view>
#include <tuple>

namespace takt::poll {
namespace {

auto settings(const model::Device& device) {
    return std::tie(device.name, device.address, device.attempts);
}

auto wire_place(const model::Variable& variable) {
    return std::tie(variable.name, variable.type, variable.area, variable.register_number, variable.bit,
                    variable.registers);
}

auto read_of(const plan::Request& r) {
    return std::tie(r.read, r.start, r.quantity, r.period, r.phase);
}

auto write_of(const plan::Request& r) {
    return std::tie(r.write, r.write_on_change, r.read_modify_write);
}

template <class Table>
std::map<std::string_view, std::size_t> by_name(const Table& table) {
    std::map<std::string_view, std::size_t> found;
    for (std::size_t i = 0; i < table.size(); ++i) found.emplace(table[i].model->name, i);
    return found;
}

}  // namespace

LineMatch::LineMatch(const LineTables& now, const LineTables& old) : now_(now), old_(old) {
    const auto old_devices = by_name(old.devices);
    for (const auto& device : now.devices) {
        const auto found = old_devices.find(device.model->name);
        const bool same = found != old_devices.end() &&
                          settings(*device.model) == settings(*old.devices[found->second].model);
        devices_.push_back(same ? std::optional(found->second) : std::nullopt);
    }
    const auto old_variables = by_name(old.variables);
    for (const auto& variable : now.variables) {
        const auto found = old_variables.find(variable.model->name);
        const bool same = found != old_variables.end() &&
                          devices_[variable.device] == old.variables[found->second].device &&
                          wire_place(*variable.model) == wire_place(*old.variables[found->second].model);
        variables_.push_back(same ? std::optional(found->second) : std::nullopt);
    }
}

std::optional<std::size_t> LineMatch::read(std::size_t now) const {
    const auto& request = now_.requests[now];
    const auto device = devices_[request.device];
    if (!device) return std::nullopt;
    const auto found = std::ranges::find_if(old_.requests, [&](const RequestRun& other) {
        return other.read && *device == other.device && read_of(*other.plan) == read_of(*request.plan) &&
               same_variables(request.variables, other.variables);
    });
    if (found == old_.requests.end()) return std::nullopt;
    return static_cast<std::size_t>(found - old_.requests.begin());
}

bool LineMatch::same_write(std::size_t now, std::size_t old) const {
    const auto& request = now_.requests[now];
    const auto& other = old_.requests[old];
    return devices_[request.device] == other.device && write_of(*other.plan) == write_of(*request.plan);
}

bool LineMatch::same_variables(std::span<const std::size_t> now, std::span<const std::size_t> old) const {
    return std::ranges::equal(now, old, [this](std::size_t n, std::size_t o) { return variables_[n] == o; });
}

bool LineMatch::share_variables(std::span<const std::size_t> now, std::span<const std::size_t> old) const {
    return std::ranges::any_of(now, [&](std::size_t n) {
        return variables_[n] && std::ranges::find(old, *variables_[n]) != old.end();
    });
}

}  // namespace takt::poll
