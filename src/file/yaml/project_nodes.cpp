#include "takt/file/project_nodes.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "takt/file/convert.hpp"
#include "takt/model/project.hpp"
#include "takt/model/scalar.hpp"
#include "yaml/nodes.hpp"

namespace takt::file {
namespace {

using model::Node;

std::string function_word(wire::Function function) {
    return fmt::format("0x{:02X}", static_cast<int>(function));
}

Node ranges_node(const model::AreaRanges& ranges) {
    auto areas = collection(Node::Kind::mapping);
    for (std::size_t area = 0; area < ranges.size(); ++area) {
        if (ranges[area].empty()) continue;
        auto list = collection(Node::Kind::list);
        for (const auto& range : ranges[area]) list.items.push_back(scalar(range_text(range)));
        set(areas, wire::name(static_cast<wire::Area>(area)), std::move(list));
    }
    return areas;
}

Node variable_node(const model::Variable& variable, Duration usual_period) {
    auto node = collection(Node::Kind::mapping);
    set(node, "name", scalar(variable.name));
    set(node, "type", scalar(takt::name(variable.type)));
    set(node, is_bit_area(variable.area) ? "coil" : "register", scalar(std::to_string(variable.start())));
    if (variable.read) set(node, "read", scalar(function_word(*variable.read)));
    if (variable.write) set(node, "write", scalar(function_word(*variable.write)));
    if (variable.read && variable.period != usual_period)
        set(node, "period", scalar(model::to_text(variable.period)));
    return node;
}

void set_ranges(Node& node, const model::Device& device, Ranges ranges) {
    auto readable = ranges_node(device.readable);
    if (!readable.entries.empty()) {
        if (ranges == Ranges::all) set(node, "offers", readable);
        set(node, "readable", std::move(readable));
    }
    if (device.registers_per_request_set)
        set(node, "registers_per_request", scalar(std::to_string(device.registers_per_request)));
    if (!device.group_requests) set(node, "group_requests", scalar("false"));
}

Node tls_node(const model::TlsFiles& files) {
    auto node = collection(Node::Kind::mapping);
    set(node, "ca", scalar(files.ca));
    set(node, "certificate", scalar(files.certificate));
    set(node, "key", scalar(files.key));
    return node;
}

}  // namespace

std::string range_text(const model::ItemRange& range) {
    return range.first == range.last ? std::to_string(range.first)
                                     : fmt::format("{}..{}", range.first, range.last);
}

Node project_node(std::vector<Node> lines) {
    auto root = collection(Node::Kind::mapping);
    set(root, "takt", scalar("1"));
    auto list = collection(Node::Kind::list);
    list.items = std::move(lines);
    set(root, "lines", std::move(list));
    return root;
}

Node line_node(const model::Line& line) {
    auto node = collection(Node::Kind::mapping);
    set(node, "name", scalar(line.name));
    for (const auto& [key, text] : connection_keys(line)) set(node, key, scalar(text));
    if (line.transport == model::Transport::tls) set(node, "tls", tls_node(line.tls));
    set(node, "devices", collection(Node::Kind::list));
    return node;
}

Node device_node(const model::Device& device, Ranges ranges) {
    auto node = collection(Node::Kind::mapping);
    set(node, "name", scalar(device.name));
    set(node, "address", scalar(std::to_string(device.address.value)));
    if (!device.comment.empty()) set(node, "comment", scalar(device.comment));
    const auto defaults = model::device_defaults(model::Profile::generic);
    if (device.poll_period != defaults.poll_period)
        set(node, "poll_period", scalar(model::to_text(device.poll_period)));
    if (device.response_timeout != defaults.response_timeout)
        set(node, "response_timeout", scalar(model::to_text(device.response_timeout)));
    if (device.turnaround) set(node, "turnaround", scalar(model::to_text(*device.turnaround)));
    if (device.fc22) set(node, "fc22", scalar("true"));
    if (device.fc23) set(node, "fc23", scalar("true"));
    set_ranges(node, device, ranges);
    auto variables = collection(Node::Kind::list);
    for (const auto& variable : device.variables)
        variables.items.push_back(variable_node(variable, device.poll_period));
    set(node, "variables", std::move(variables));
    return node;
}

Node range_keys(const model::Device& device, Ranges ranges) {
    auto node = collection(Node::Kind::mapping);
    set_ranges(node, device, ranges);
    return node;
}

}  // namespace takt::file
