#include "takt/discover/found_project.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "takt/model/project.hpp"
#include "takt/model/target_url.hpp"

namespace takt::discover {
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

/// The item that the unit was found by, when it answered with a value.
std::vector<model::Variable> variables_of(const FoundUnit& unit, std::size_t line_number) {
    using wire::Area;
    using wire::Function;
    struct Question {
        Function function;
        Area area;
        const char* name;
    };
    static constexpr std::array kQuestions{
        Question{Function::read_holding_registers, Area::holding_register, "holding"},
        Question{Function::read_input_registers, Area::input_register, "input"},
        Question{Function::read_coils, Area::coil, "coil"}};
    const auto* const asked =
        std::ranges::find(kQuestions, static_cast<Function>(unit.function), &Question::function);
    if (unit.exception != 0 || asked == kQuestions.end()) return {};
    model::Variable variable;
    variable.name = "line" + std::to_string(line_number) + "_unit" + std::to_string(unit.unit.value) + "_" +
                    asked->name + "_0";
    variable.area = asked->area;
    variable.read = asked->function;
    variable.type = is_bit_area(asked->area) ? DataType::boolean : DataType::uint16;
    if (is_bit_area(asked->area)) variable.bit = 0;
    return {variable};
}

model::Device device_of(const FoundUnit& unit, std::size_t line_number) {
    model::Device device;
    device.response_timeout = model::device_defaults(model::Profile::generic).response_timeout;
    device.name = "unit " + std::to_string(unit.unit.value);
    device.address = unit.unit;
    const auto response_time = std::chrono::floor<std::chrono::milliseconds>(unit.response_time);
    if (response_time >= device.response_timeout / 2)
        device.response_timeout = std::min<Duration>(3 * response_time, kLongestTimeout);
    device.variables = variables_of(unit, line_number);
    return device;
}

}  // namespace

FoundProject found_project(const ScanFindings& findings) {
    auto groups = by_line(findings);
    std::ranges::stable_sort(groups, std::greater(), &Group::size);
    FoundProject project;
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
        for (const auto* device : group) made.line.devices.push_back(device_of(device->unit, number));
    }
    return project;
}

}  // namespace takt::discover
