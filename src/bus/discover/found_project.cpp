#include "takt/bus/found_project.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "takt/model/project.hpp"
#include "takt/model/target_url.hpp"

namespace takt::bus {
namespace {

using namespace std::chrono_literals;
using Group = std::vector<const FoundDevice*>;

constexpr Duration kLongestTimeout = 65535ms;

/// Devices by the URL of their line, in the order in which the lines were found.
std::vector<Group> by_line(const ScanFindings& findings) {
    std::vector<Group> groups;
    std::map<std::string, std::size_t> known;
    for (const auto& device : findings.devices) {
        const auto [at, added] = known.try_emplace(model::url_of(device.line), groups.size());
        if (added) groups.emplace_back();
        groups[at->second].push_back(&device);
    }
    return groups;
}

/// A read of an area, and its word in the names of variables.
struct AreaRead {
    wire::Function function;
    wire::Area area;
    const char* word;
};
constexpr std::array kReads{
    AreaRead{wire::Function::read_holding_registers, wire::Area::holding_register, "holding"},
    AreaRead{wire::Function::read_input_registers, wire::Area::input_register, "input"},
    AreaRead{wire::Function::read_coils, wire::Area::coil, "coil"},
    AreaRead{wire::Function::read_discrete_inputs, wire::Area::discrete_input, "discrete"}};

model::Variable variable_of(const AreaRead& read, const std::string& prefix, std::uint16_t item) {
    constexpr std::uint16_t kBitsOfRegister = 16;
    model::Variable variable;
    variable.name = prefix + read.word + "_" + std::to_string(item);
    variable.area = read.area;
    variable.read = read.function;
    const bool bits = is_bit_area(read.area);
    variable.type = bits ? DataType::boolean : DataType::uint16;
    variable.register_number = bits ? static_cast<std::uint16_t>(item / kBitsOfRegister) : item;
    if (bits) variable.bit = static_cast<std::uint8_t>(item % kBitsOfRegister);
    return variable;
}

/// The item that the unit was found by, when it answered with a value.
std::vector<model::Variable> found_variables(const FoundUnit& unit, const std::string& prefix) {
    const auto* const asked =
        std::ranges::find(kReads, static_cast<wire::Function>(unit.function), &AreaRead::function);
    if (unit.exception != 0 || asked == kReads.end()) return {};
    return {variable_of(*asked, prefix, 0)};
}

std::vector<model::Variable> probed_variables(const ProbeFindings& probe, const std::string& prefix) {
    std::vector<model::Variable> variables;
    for (const auto& area : probe.areas) {
        const auto* const read = std::ranges::find(kReads, area.area, &AreaRead::area);
        for (const auto& range : area.result.readable)
            for (std::uint32_t item = range.first; item <= range.last; ++item) {
                if (variables.size() == kMostFoundVariables) return variables;
                variables.push_back(variable_of(*read, prefix, static_cast<std::uint16_t>(item)));
            }
    }
    return variables;
}

bool addresses_host(const FoundDevice& device) {
    const auto unit = device.unit.unit.value;
    return device.line.framing == wire::Framing::tcp && (unit == 0 || unit == 255);
}

/// Another unit of the group that answers and identifies itself as this one of the host does.
bool has_twin(const FoundDevice& device, const Group& group) {
    const auto alike = [&](const FoundDevice* other) {
        const bool counts = !addresses_host(*other) || other->unit.unit.value > device.unit.unit.value;
        return other != &device && counts && other->unit.function == device.unit.function &&
               other->unit.exception == device.unit.exception && other->unit.identity == device.unit.identity;
    };
    return addresses_host(device) && std::ranges::any_of(group, alike);
}

model::Device device_of(const FoundUnit& unit, std::size_t line_number, const ProbeFindings* probe) {
    const auto defaults = model::device_defaults(model::Profile::generic);
    model::Device device;
    device.poll_period = defaults.poll_period;
    device.response_timeout = defaults.response_timeout;
    device.group_requests = defaults.group_requests;
    device.name = "unit " + std::to_string(unit.unit.value);
    device.address = unit.unit;
    const auto response_time = std::chrono::floor<std::chrono::milliseconds>(unit.response_time);
    if (response_time >= device.response_timeout / 2)
        device.response_timeout = std::min<Duration>(3 * response_time, kLongestTimeout);
    const auto prefix =
        "line" + std::to_string(line_number) + "_unit" + std::to_string(unit.unit.value) + "_";
    device.variables = probe ? probed_variables(*probe, prefix) : found_variables(unit, prefix);
    for (auto& variable : device.variables) variable.period = device.poll_period;
    if (probe) set_ranges(device, *probe);
    return device;
}

}  // namespace

void set_ranges(model::Device& device, const ProbeFindings& probe) {
    for (const auto& area : probe.areas)
        device.readable[static_cast<std::size_t>(area.area)] = area.result.readable;
    if (const auto registers = probe.longest_register_read()) {
        device.registers_per_request = *registers;
        device.registers_per_request_set = true;
    }
    if (probe.one_register_only()) device.group_requests = false;
}

FoundProject found_project(const ScanFindings& findings, const DeviceProbes& probes) {
    auto groups = by_line(findings);
    FoundProject project;
    for (auto& group : groups) {
        const Group all = group;
        std::erase_if(group, [&](const FoundDevice* device) {
            const bool twin = has_twin(*device, all);
            if (twin) project.same.push_back(device);
            return twin;
        });
    }
    std::ranges::stable_sort(groups, std::greater(), &Group::size);
    std::set<std::string> ports;
    for (const auto& group : groups) {
        const auto& line = group.front()->line;
        const bool serial = line.transport == model::Transport::serial;
        if (serial && !ports.insert(line.port).second) {
            project.others.insert(project.others.end(), group.begin(), group.end());
            continue;
        }
        const std::size_t number = project.lines.size() + 1;
        auto& made = project.lines.emplace_back(FoundLine{line, group});
        made.line.name = "line " + std::to_string(number);
        made.line.devices.clear();
        for (const auto* device : group) {
            const auto probe = probes.find(device);
            made.line.devices.push_back(
                device_of(device->unit, number, probe == probes.end() ? nullptr : &probe->second));
        }
    }
    return project;
}

}  // namespace takt::bus
