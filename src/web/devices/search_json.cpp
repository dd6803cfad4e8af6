#include "devices/search_json.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <variant>

#include "takt/bus/found_project.hpp"
#include "takt/file/document_json.hpp"
#include "takt/file/json_members.hpp"
#include "takt/model/target_url.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/states/probe_report.hpp"
#include "takt/report/states/scan_report.hpp"

namespace takt::web {
namespace {

using SearchState = DeviceSearch::State;

std::string target_of(const std::string& project_line) {
    return std::string(kLineTarget) + project_line;
}

std::string_view search_kind_word(DeviceSearch::Kind kind) {
    switch (kind) {
        case DeviceSearch::Kind::none: return "none";
        case DeviceSearch::Kind::scan: return "scan";
        case DeviceSearch::Kind::probe: return "probe";
    }
    return "";
}

bool is_same(const model::Line& a, const model::Line& b) {
    return model::url_of(a) == model::url_of(b);
}

file::Json json_of_node(const model::Node& node) {
    return file::without_origins(file::document_json(node));
}

/// The nodes that found devices would be in a project document.
struct Nodes {
    file::Json line;  ///< without devices
    file::Json device;
};

bus::DeviceProbes probes_of(const SearchState& state) {
    bus::DeviceProbes probes;
    for (const auto& device : state.findings.devices)
        for (const auto& probed : state.probed)
            if (probed.unit == device.unit.unit && is_same(probed.line, device.line))
                probes.emplace(&device, probed.findings);
    return probes;
}

std::map<const bus::FoundDevice*, Nodes> nodes_of(const SearchState& state) {
    std::map<const bus::FoundDevice*, Nodes> nodes;
    if (state.findings.devices.empty()) return nodes;
    const auto found = report::found_nodes(state.findings, probes_of(state));
    for (std::size_t l = 0; l < found.lines.size(); ++l) {
        auto without_devices = found.lines[l];
        without_devices.entries.pop_back();
        const auto line = json_of_node(without_devices);
        const auto& devices = found.lines[l].entries.back().value.items;
        for (std::size_t d = 0; d < devices.size(); ++d)
            nodes.emplace(found.project.lines[l].found[d], Nodes{line, json_of_node(devices[d])});
    }
    return nodes;
}

/// The line of the project that something was found on: by its name, if the search went through it.
const model::Line* line_of_device(const model::Project& project, const std::string& name,
                                  const model::Line& found) {
    if (name.empty()) return line_with_endpoint(project, found);
    const auto line = std::ranges::find(project.lines, name, &model::Line::name);
    return line == project.lines.end() ? nullptr : &*line;
}

/// The name of the project's device at an address; null: none.
file::Json known_device(const model::Line* line, UnitId unit) {
    if (!line) return {};
    const auto device = std::ranges::find(line->devices, unit, &model::Device::address);
    return device == line->devices.end() ? file::Json() : file::Json(device->name);
}

file::Json devices_json(const SearchState& state, const model::Project& project, const file::Json& scanned) {
    const auto nodes = nodes_of(state);
    const auto& entries = array_member(scanned, "devices");
    auto list = file::Json::array();
    for (std::size_t i = 0; i < state.findings.devices.size(); ++i) {
        const auto& device = state.findings.devices[i];
        auto object = entries[i];
        object.set("identity", report::identity_text(device.unit.identity));
        const auto* const line = line_of_device(project, state.project_line, device.line);
        if (!state.project_line.empty()) object.set("target", target_of(state.project_line));
        object.set("line", line ? file::Json(line->name) : file::Json());
        object.set("known_as", known_device(line, device.unit.unit));
        const auto its = nodes.find(&device);
        const bool has_line = its == nodes.end() || !state.project_line.empty();
        object.set("line_node", has_line ? file::Json() : its->second.line);
        object.set("device_node", its == nodes.end() ? file::Json() : its->second.device);
        list.push_back(std::move(object));
    }
    return list;
}

file::Json probed_json(const report::Texts& texts, const DeviceSearch::Probed& probed,
                       const model::Project& project) {
    const report::ProbeRun run{.target = model::url_of(probed.line),
                               .unit = probed.unit.value,
                               .transmissions = probed.transmissions,
                               .duration = probed.duration,
                               .interrupted = probed.interrupted};
    auto object = report::probe_json(probed.findings, run);
    object.set("text", report::probe_text(probed.findings));
    object.set("summary", report::probe_summary(texts, probed.findings, run));
    const auto* const line = line_of_device(project, probed.project_line, probed.line);
    if (!probed.project_line.empty()) object.set("target", target_of(probed.project_line));
    object.set("line", line ? file::Json(line->name) : file::Json());
    object.set("known_as", known_device(line, probed.unit));
    const auto keys = report::probe_keys(probed.findings);
    object.set("keys", keys.entries.empty() ? file::Json::object() : json_of_node(keys));
    return object;
}

}  // namespace

const model::Line* line_with_endpoint(const model::Project& project, const model::Line& wanted) {
    const auto same = [&](const model::Line& line) {
        if (line.transport == model::Transport::simulated) return false;
        const bool serial = wanted.transport == model::Transport::serial;
        if ((line.transport == model::Transport::serial) != serial || line.port != wanted.port) return false;
        return serial || line.tcp_port == wanted.tcp_port;
    };
    const auto found = std::ranges::find_if(project.lines, same);
    return found == project.lines.end() ? nullptr : &*found;
}

file::Json search_json(const report::Texts& texts, const SearchState& state,
                       const host::Configuration& configuration) {
    const auto& project = configuration.project();
    const auto scanned = report::scan_json(texts, state.findings);
    auto object = file::Json::object();
    object.set("id", state.id);
    object.set("kind", search_kind_word(state.kind));
    object.set("running", state.running);
    object.set("cancelled", state.cancelled);
    object.set("elapsed_ms", report::milliseconds(state.elapsed));
    object.set("done", state.done);
    object.set("total", state.total);
    object.set("requests", state.requests);
    object.set("where", state.kind == DeviceSearch::Kind::scan && !state.project_line.empty()
                            ? target_of(state.project_line)
                            : state.where);
    object.set("error", state.error ? file::Json(texts.describe(*state.error)) : file::Json());
    object.set("devices", devices_json(state, project, scanned));
    object.set("troubles", *scanned.find("troubles"));
    object.set("absent_hosts", state.findings.absent_hosts);
    auto probed = file::Json::array();
    for (const auto& one : state.probed) probed.push_back(probed_json(texts, one, project));
    object.set("probed", std::move(probed));
    return object;
}

}  // namespace takt::web
