// The project file of a heard line.
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "takt/file/convert.hpp"
#include "takt/file/project_nodes.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/times/listen_report.hpp"
#include "takt/text/escape.hpp"

namespace takt::report {
namespace {

/// Of all devices together. With 64 lines of 247 devices and all their keys, the file stays within the limits
/// of files (takt/file/load.hpp).
constexpr std::size_t kMostVariablesOfAll = 20'000;

/// Variables of each device, so that all lines share the file alike.
std::size_t most_variables(std::span<const ListenRun> runs) {
    std::size_t devices = 0;
    for (const auto& run : runs) devices += capture::heard_devices(run.statistics);
    if (devices == 0) return capture::kMostVariables;
    return std::clamp<std::size_t>(kMostVariablesOfAll / devices, 1, capture::kMostVariables);
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

std::string other_units_text(const Texts& texts, const capture::HeardProject& project) {
    std::string others;
    for (const auto unit : project.other_units)
        others += fmt::format("{}{}", others.empty() ? "" : ", ", unit);
    return others.empty() ? others : texts("app.listen.project_units", {{"units", others}}) + '\n';
}

}  // namespace

std::string listen_project(const Texts& texts, std::span<const ListenRun> runs, int stretch) {
    auto text = fmt::format("# {}\n", texts("app.listen.project_head"));
    if (std::ranges::any_of(runs,
                            [](const ListenRun& run) { return !run.has_settings && !run.settings_given; }))
        text += fmt::format("# {}\n", texts("app.listen.project_settings"));
    if (stretch > 1)
        text += fmt::format("# {}\n",
                            texts("app.listen.project_stretched", {{"factor", std::to_string(stretch)}}));
    const auto most = most_variables(runs);
    std::vector<capture::HeardProject> projects;
    std::vector<std::string> names;  // of lines of a capture
    for (std::size_t i = 0; i < runs.size(); ++i) {
        auto project = capture::heard_project(runs[i].statistics, runs[i].connection, stretch, most);
        if (project.line.devices.empty()) continue;
        if (runs.size() > 1) number_names(project.line, i + 1);
        names.push_back(runs.size() > 1 ? text::escape_line(runs[i].line) + '\n' : std::string());
        projects.push_back(std::move(project));
    }
    auto root = file::project_node({});
    auto& lines = root.entries.back().value.items;
    for (const auto& project : projects) {
        auto& devices = lines.emplace_back(file::line_node(project.line)).entries.back().value.items;
        for (const auto& device : project.line.devices)
            devices.push_back(file::device_node(device, file::Ranges::read));
    }
    file::Comments comments;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        comments[&lines[i]] = names[i] + other_units_text(texts, projects[i]);
        const auto& devices = lines[i].entries.back().value.items;
        for (std::size_t d = 0; d < devices.size(); ++d)
            if (const auto count = projects[i].left_out[d]; count > 0)
                comments[&devices[d]] =
                    texts("app.listen.project_left_out", {{"count", std::to_string(count)}});
    }
    return text + file::write_project(root, comments);
}

}  // namespace takt::report
