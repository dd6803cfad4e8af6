// The rows of tables from a project. Values that a variable inherits are written out, so that a table is
// complete without the project.
#include <algorithm>

#include "takt/base/data_type.hpp"
#include "takt/file/convert.hpp"
#include "takt/file/table.hpp"
#include "takt/model/byte_order.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/scalar.hpp"
#include "takt/model/target_url.hpp"
#include "yaml/nodes.hpp"

namespace takt::file {
namespace {

using model::Node;

// The order of the bytes of a variable, from its keys and those of its device.
ByteOrder order_of(const Node& device, const Node& variable) {
    ByteOrder order;
    for (const auto* const owner : {&device, &variable}) {
        if (const auto flag = model::parse_bool(text_of(*owner, "high_byte_first")))
            order.high_byte_first = *flag;
        if (const auto flag = model::parse_bool(text_of(*owner, "high_register_first")))
            order.high_register_first = *flag;
        if (const auto stated = model::parse_byte_order(text_of(*owner, "byte_order"))) {
            order.high_byte_first = stated->order.high_byte_first;
            if (stated->bytes > 2) order.high_register_first = stated->order.high_register_first;
        }
    }
    return order;
}

// Whether a variable is a coil or a discrete input, which has no order of bytes.
bool is_coil(const Node& variable) {
    const auto area = text_of(variable, "area");
    const auto reference = text_of(variable, "reference");
    if (!area.empty() || !reference.empty())
        return area == "coil" || area == "discrete_input" || reference.starts_with('0') ||
               reference.starts_with('1');
    for (const std::string_view key : {"read", "write"})
        if (const auto number = model::parse_integer(text_of(variable, key)))
            return number->magnitude == 1 || number->magnitude == 2 || number->magnitude == 5 ||
                   number->magnitude == 15;
    return variable.find("coil") != nullptr;
}

// A default or inherited order is not written unless the project names it. A coil inherits none.
void put_byte_order(Node& row, const Node& device, const Node& variable) {
    if (is_coil(variable) && variable.find("byte_order") == nullptr) return;
    const auto order = order_of(device, variable);
    const bool named = device.find("byte_order") != nullptr || variable.find("byte_order") != nullptr;
    if (order == ByteOrder{} && !named) return;
    set(row, "byte_order", scalar(model::byte_order_text(order, 2), row.location));
}

// Numbers with words in the form of a cell: `0=off, 1=on`; a list of words: `a, b`.
Node in_one_cell(std::string_view key, const Node& value) {
    if (value.kind == Node::Kind::list) {
        std::string text;
        for (const auto& item : value.items) text.append(text.empty() ? "" : ", ").append(item.text);
        return text.empty() ? Node{} : scalar(text, value.location);
    }
    const auto* const field = model::find_field(model::Object::variable, key);
    const bool words = field != nullptr && field->kind == model::Kind::words;
    if (!words || value.kind != Node::Kind::mapping) return value;
    std::string text;
    for (const auto& [number, word] : value.entries)
        text.append(text.empty() ? "" : ", ").append(number.text).append("=").append(word.text);
    return scalar(text, value.location);
}

Node row_of(const Node& line, const Node& device, const Node& variable) {
    auto row = collection(Node::Kind::mapping, variable.location);
    if (const auto* const name = line.find("name")) set(row, kLineColumn, *name);
    if (const auto* const name = device.find("name")) set(row, kDeviceColumn, *name);
    if (const auto* const address = device.find("address")) set(row, kUnitAddressColumn, *address);
    for (const auto& [key, value] : variable.entries)
        row.entries.emplace_back(key, in_one_cell(key.text, value));
    const auto* const period = device.find("poll_period");
    if (period != nullptr && period->kind == Node::Kind::scalar && variable.find("period") == nullptr &&
        model::parse_duration(period->text) != model::Device().poll_period)
        set(row, "period", *period);
    put_byte_order(row, device, variable);
    return row;
}

const std::vector<Node>& items(const Node& mapping, std::string_view key) {
    static const std::vector<Node> kNone;
    const auto* const list = mapping.find(key);
    return list == nullptr ? kNone : list->items;
}

// The connection of each line; empty: a simulated one.
std::vector<std::string> targets_of(const model::Document& document) {
    std::vector<std::string> targets;
    for (const auto& line : model::interpret(document).project.lines)
        targets.push_back(line.transport == model::Transport::simulated ? "" : model::url_of(line));
    return targets;
}

}  // namespace

std::vector<Node> rows_of_locals(const model::Document& document) {
    return items(document.root, "locals");
}

std::vector<Node> rows_of_servers(const model::Document& document) {
    std::vector<Node> rows;
    for (const auto& server : items(document.root, "servers"))
        for (const auto& unit : items(server, "units"))
            for (const auto& variable : items(unit, "variables")) {
                rows.push_back(variable);
                for (auto& [key, value] : rows.back().entries) value = in_one_cell(key.text, value);
                put_byte_order(rows.back(), unit, variable);
            }
    return rows;
}

std::vector<Node> rows_of_project(const model::Document& document) {
    std::vector<Node> rows;
    const auto& lines = items(document.root, "lines");
    const auto targets = lines.size() > 1 ? targets_of(document) : std::vector<std::string>(lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i)
        for (const auto& device : items(lines[i], "devices"))
            for (const auto& variable : items(device, "variables")) {
                rows.push_back(row_of(lines[i], device, variable));
                if (!targets[i].empty()) set(rows.back(), kTargetColumn, scalar(targets[i]));
            }
    return rows;
}

std::vector<Node> rows_of_device(const std::vector<Node>& rows, const std::string& device) {
    std::vector<Node> selected;
    for (const auto& row : rows)
        if (text_of(row, kDeviceColumn) == device) selected.push_back(without_place(row));
    return selected;
}

std::vector<std::string> devices_of(const std::vector<Node>& rows) {
    std::vector<std::string> names;
    for (const auto& row : rows)
        if (const auto* const cell = row.find(kDeviceColumn))
            if (std::ranges::find(names, cell->text) == names.end()) names.push_back(cell->text);
    return names;
}

}  // namespace takt::file
