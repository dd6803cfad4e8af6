// The project file of a heard line.
#include <fmt/format.h>

#include <algorithm>

#include "plans/project_text.hpp"
#include "takt/model/fields.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/listen_report.hpp"
#include "takt/text/escape.hpp"

namespace takt::report {
namespace {

std::string period_yaml(Duration period) {
    return fmt::format("{}ms", period / std::chrono::milliseconds(1));
}

std::string readable_yaml(const model::Device& device) {
    std::string text;
    for (std::size_t area = 0; area < device.readable.size(); ++area) {
        if (device.readable[area].empty()) continue;
        std::string ranges;
        for (const auto& range : device.readable[area])
            ranges += fmt::format("{}{}", ranges.empty() ? "" : ", ", range_text(range));
        text += fmt::format("          {}: [{}]\n", wire::name(static_cast<wire::Area>(area)), ranges);
    }
    return text.empty() ? text : "        readable:\n" + text;
}

std::string variable_yaml(const model::Variable& variable, Duration usual) {
    const bool coil = is_bit_area(variable.area);
    auto text = fmt::format("          - {{name: {}, type: {}, {}: {}", variable.name,
                            takt::name(variable.type), coil ? "coil" : "register", variable.start());
    if (variable.read) text += fmt::format(", read: {}", function_text(*variable.read));
    if (variable.write) text += fmt::format(", write: {}", function_text(*variable.write));
    if (variable.read && variable.period != usual)
        text += fmt::format(", period: {}", period_yaml(variable.period));
    return text + "}\n";
}

std::string heard_device_yaml(const Texts& texts, const model::Device& device, std::size_t left_out) {
    auto text = fmt::format("      - name: {}\n        address: {}\n        poll_period: {}\n", device.name,
                            device.address.value, period_yaml(device.poll_period));
    if (device.response_timeout != model::device_defaults(model::Profile::generic).response_timeout)
        text += fmt::format("        response_timeout: {}\n", period_yaml(device.response_timeout));
    if (device.registers_per_request_set)
        text += fmt::format("        registers_per_request: {}\n", device.registers_per_request);
    if (device.fc22) text += "        fc22: true\n";
    if (device.fc23) text += "        fc23: true\n";
    text += readable_yaml(device);
    if (device.variables.empty()) return text + "        variables: []\n";
    text += "        variables:\n";
    for (const auto& variable : device.variables) text += variable_yaml(variable, device.poll_period);
    if (left_out > 0)
        text += fmt::format("          # {}\n",
                            texts("app.listen.project_left_out", {{"count", std::to_string(left_out)}}));
    return text;
}

/// Of all devices together. With 64 lines of 247 devices and all their keys, the file stays within the limits
/// of files (takt/file/load.hpp).
constexpr std::size_t kMostVariablesOfAll = 20'000;

/// Variables of each device, so that all lines share the file alike.
std::size_t most_variables(std::span<const ListenRun> runs) {
    std::size_t devices = 0;
    for (const auto& run : runs) devices += listen::heard_devices(run.statistics);
    if (devices == 0) return listen::kMostVariables;
    return std::clamp<std::size_t>(kMostVariablesOfAll / devices, 1, listen::kMostVariables);
}

// Names are unique in a project.
void number_names(model::Line& line, std::size_t number) {
    line.name = "line " + std::to_string(number);
    if (line.transport == model::Transport::serial) line.port = "/dev/ttyUSB" + std::to_string(number - 1);
    for (auto& device : line.devices) {
        device.name = line.name + ' ' + device.name;
        for (auto& variable : device.variables)
            variable.name = "line" + std::to_string(number) + '_' + variable.name;
    }
}

std::string line_yaml(const Texts& texts, const listen::HeardProject& project) {
    auto text =
        fmt::format("  - name: {}\n{}    devices:\n", project.line.name, connection_yaml(project.line));
    for (std::size_t i = 0; i < project.line.devices.size(); ++i)
        text += heard_device_yaml(texts, project.line.devices[i], project.left_out[i]);
    std::string others;
    for (const auto unit : project.other_units)
        others += fmt::format("{}{}", others.empty() ? "" : ", ", unit);
    if (!others.empty())
        text += fmt::format("# {}\n", texts("app.listen.project_units", {{"units", others}}));
    return text;
}

}  // namespace

std::string listen_project(const Texts& texts, std::span<const ListenRun> runs, int stretch) {
    auto text = fmt::format("# {}\n", texts("app.listen.project_head"));
    if (std::ranges::any_of(runs, [](const ListenRun& run) { return !run.has_settings; }))
        text += fmt::format("# {}\n", texts("app.listen.project_settings"));
    if (stretch > 1)
        text += fmt::format("# {}\n",
                            texts("app.listen.project_stretched", {{"factor", std::to_string(stretch)}}));
    text += "takt: 1\nlines:\n";
    const auto most = most_variables(runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        auto project = listen::heard_project(runs[i].statistics, runs[i].connection, stretch, most);
        if (project.line.devices.empty()) continue;
        if (runs.size() > 1) {
            number_names(project.line, i + 1);
            text += "  # " + text::escape_line(runs[i].line) + '\n';
        }
        text += line_yaml(texts, project);
    }
    return text;
}

}  // namespace takt::report
