#include "takt/report/plans/register_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <tuple>
#include <vector>

#include "takt/model/byte_order.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/item_ranges.hpp"
#include "takt/model/value_words.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kMapColumns = 14;
constexpr std::array<std::string_view, kMapColumns> kMapKeys{
    "area",       "first", "reference", "registers", "bit",    "name",  "type",
    "byte_order", "scale", "offset",    "unit",      "access", "words", "comment"};

using MapCells = std::array<std::string, kMapColumns>;

/// 40001 for holding register 0; six digits beyond 9999.
std::string reference_of(wire::Area area, unsigned start) {
    const char digit = "0134"[static_cast<std::size_t>(area)];
    const unsigned number = start + 1;
    return number <= 9999 ? fmt::format("{}{:04}", digit, number) : fmt::format("{}{:05}", digit, number);
}

bool is_written(const model::ServerUnit& unit, std::size_t index) {
    const auto& variable = unit.variables[index];
    if (variable.area == wire::Area::input_register || variable.area == wire::Area::discrete_input)
        return false;
    const auto& read_only = unit.read_only[static_cast<std::size_t>(variable.area)];
    const model::ItemRange first{variable.start(), variable.start()};
    if (model::holds(read_only, first)) return false;
    const auto binding = std::ranges::find(unit.bindings, index, &model::Binding::variable);
    return binding == unit.bindings.end() || !binding->source || binding->sink;
}

MapCells map_cells(const model::ServerUnit& unit, std::size_t index) {
    const auto& variable = unit.variables[index];
    const bool bits = wire::is_bit_area(variable.area);
    auto words = model::text_of(variable.enumeration);
    if (!variable.bits.empty()) words += (words.empty() ? "" : "; ") + model::text_of(variable.bits);
    return {std::string(model::kAreas[static_cast<std::size_t>(variable.area)]),
            std::to_string(variable.start()),
            reference_of(variable.area, variable.start()),
            std::to_string(variable.items()),
            variable.bit && !bits ? std::to_string(*variable.bit) : "",
            variable.name,
            std::string(name(variable.type)),
            bits ? "" : std::string(model::byte_order_text(variable.order, variable.type)),
            variable.scaled() ? fmt::format("{}", variable.scale) : "",
            variable.scaled() ? fmt::format("{}", variable.offset) : "",
            variable.unit,
            is_written(unit, index) ? "RW" : "R",
            words,
            variable.comment};
}

/// The used variables of a unit, by area and address.
std::vector<std::size_t> used_in_order(const model::ServerUnit& unit) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < unit.variables.size(); ++i)
        if (unit.variables[i].used) order.push_back(i);
    std::ranges::sort(order, {}, [&](std::size_t i) {
        const auto& variable = unit.variables[i];
        return std::tuple(variable.area, variable.start(), variable.bit.value_or(0), i);
    });
    return order;
}

std::string markdown_cell(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '|' || c == '\\' || c == '`' || c == '<' || c == '*' || c == '_') escaped += '\\';
        escaped += c;
    }
    return escaped;
}

/// Whether any variable of the unit has the column; the first seven and the access always are there.
std::array<bool, kMapColumns> used_columns(const std::vector<MapCells>& rows) {
    std::array<bool, kMapColumns> used{};
    for (std::size_t column = 0; column < kMapColumns; ++column)
        used[column] = std::ranges::any_of(rows, [&](const MapCells& row) { return !row[column].empty(); });
    return used;
}

}  // namespace

std::size_t count_served(const model::Project& project) {
    std::size_t count = 0;
    for (const auto& server : project.servers)
        for (const auto& unit : server.units) count += used_in_order(unit).size();
    return count;
}

std::string register_map_csv(const model::Project& project, char separator) {
    std::string text = fmt::format("server{0}unit_address", separator);
    for (const auto key : kMapKeys) text.append(1, separator).append(key);
    text += "\r\n";
    for (const auto& server : project.servers)
        for (const auto& unit : server.units)
            for (const auto index : used_in_order(unit)) {
                text += csv_cell(server.name, separator);
                text += separator + std::to_string(unit.address.value);
                for (const auto& cell : map_cells(unit, index)) text += separator + csv_cell(cell, separator);
                text += "\r\n";
            }
    return text;
}

std::string register_map_markdown(const Texts& texts, const model::Project& project) {
    std::string text;
    for (const auto& server : project.servers)
        for (const auto& unit : server.units) {
            std::vector<MapCells> rows;
            for (const auto index : used_in_order(unit)) rows.push_back(map_cells(unit, index));
            if (rows.empty()) continue;
            const auto used = used_columns(rows);
            text += (text.empty() ? "# " : "\n# ") +
                    texts("map.title", {{"server", markdown_cell(server.name)},
                                        {"unit", std::to_string(unit.address.value)}}) +
                    "\n\n";
            std::string rule = "|";
            text += '|';
            for (std::size_t column = 0; column < kMapColumns; ++column) {
                if (!used[column]) continue;
                text += ' ' + texts("map." + std::string(kMapKeys[column])) + " |";
                rule += " --- |";
            }
            text += '\n' + rule + '\n';
            for (const auto& row : rows) {
                text += '|';
                for (std::size_t column = 0; column < kMapColumns; ++column)
                    if (used[column]) text += ' ' + markdown_cell(row[column]) + " |";
                text += '\n';
            }
        }
    if (text.empty()) return texts("map.empty") + '\n';
    return text + '\n' + texts("map.notes") + '\n';
}

}  // namespace takt::report
