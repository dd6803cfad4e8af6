#include "yaml/nodes.hpp"

#include <algorithm>

#include "takt/file/table.hpp"

namespace takt::file {

using model::Node;
using model::SourceLocation;

Node scalar(std::string_view text, const SourceLocation& location) {
    Node node;
    node.kind = Node::Kind::scalar;
    node.location = location;
    node.text = text;
    return node;
}

Node collection(Node::Kind kind, const SourceLocation& location) {
    Node node;
    node.kind = kind;
    node.location = location;
    return node;
}

Node* find_value(Node& mapping, std::string_view key) {
    for (auto& [name, value] : mapping.entries)
        if (name.text == key) return &value;
    return nullptr;
}

void set(Node& mapping, std::string_view key, Node value) {
    if (auto* const old = find_value(mapping, key))
        *old = std::move(value);
    else
        mapping.entries.emplace_back(scalar(key), std::move(value));
}

Node list_of(Node item) {
    auto list = collection(Node::Kind::list);
    list.items.push_back(std::move(item));
    return list;
}

Node mapping_of(const std::vector<std::pair<std::string, std::string>>& settings,
                const SourceLocation& location) {
    auto node = collection(Node::Kind::mapping, location);
    for (const auto& [key, text] : settings) set(node, key, scalar(text, location));
    return node;
}

bool names_place(std::string_view key) {
    return key == kLineColumn || key == kTargetColumn || key == kDeviceColumn || key == kUnitAddressColumn ||
           std::ranges::find(kDeviceSettings, key) != kDeviceSettings.end();
}

std::string text_of(const Node& row, std::string_view key) {
    const auto* const cell = row.find(key);
    return cell == nullptr ? std::string() : cell->text;
}

Node without_place(const Node& row) {
    Node bare = row;
    std::erase_if(bare.entries, [](const Node::Entry& entry) { return names_place(entry.key.text); });
    return bare;
}

}  // namespace takt::file
