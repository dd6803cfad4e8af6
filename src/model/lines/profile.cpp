#include <algorithm>
#include <tuple>
#include <utility>

#include "servers/interpretation.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kDevices = 32;
constexpr std::size_t kVariables = 1024;

struct Seat {
    std::size_t line;
    std::size_t device;
};

std::string path_of(Seat seat) {
    return "lines[" + std::to_string(seat.line) + "].devices[" + std::to_string(seat.device) + "]";
}

std::vector<Seat> by_address(const Project& project) {
    std::vector<Seat> seats;
    for (std::size_t line = 0; line < project.lines.size(); ++line)
        for (std::size_t device = 0; device < project.lines[line].devices.size(); ++device)
            seats.push_back({line, device});
    std::ranges::sort(seats, {}, [&](Seat seat) {
        return std::tuple(project.lines[seat.line].devices[seat.device].address, seat.line, seat.device);
    });
    return seats;
}

/// Removes the variables beyond `limit` from a device. @returns how many stay
std::size_t cut_variables(Interpretation& state, Seat seat, std::size_t limit) {
    auto& variables = state.project.lines[seat.line].devices[seat.device].variables;
    if (variables.size() <= limit) return variables.size();
    const auto& first = variables[limit];
    state.findings.add(
        Rule::profile_too_many_variables, first.location,
        path_of(seat) + ".variables[" + std::to_string(limit) + "]", first.name,
        "1.." + std::to_string(kVariables),
        {{"count", std::to_string(variables.size() - limit)}, {"limit", std::to_string(kVariables)}});
    variables.resize(limit);
    return limit;
}

}  // namespace

void apply_profile(Interpretation& state) {
    auto& project = state.project;
    if (project.profile != Profile::owen_kc1) return;
    const auto seats = by_address(project);
    std::size_t left = kVariables;
    for (std::size_t i = 0; i < std::min(seats.size(), kDevices); ++i)
        left -= cut_variables(state, seats[i], left);
    std::vector<Seat> beyond(seats.begin() + static_cast<std::ptrdiff_t>(std::min(seats.size(), kDevices)),
                             seats.end());
    std::ranges::sort(beyond, {}, [](Seat seat) { return std::pair(seat.line, seat.device); });
    for (const auto seat : beyond) {
        const auto& device = project.lines[seat.line].devices[seat.device];
        state.findings.add(Rule::profile_too_many_devices, device.location, path_of(seat), device.name,
                           "1.." + std::to_string(kDevices), {{"limit", std::to_string(kDevices)}});
    }
    while (!beyond.empty()) {
        auto& devices = project.lines[beyond.back().line].devices;
        devices.erase(devices.begin() + static_cast<std::ptrdiff_t>(beyond.back().device));
        beyond.pop_back();
    }
}

}  // namespace takt::model
