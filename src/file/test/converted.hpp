// Projects of tables, and their variables as text.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "outline.hpp"
#include "takt/file/convert.hpp"

namespace takt::file {

using Findings = std::vector<std::string>;

inline const Surroundings kAround{{{"name", "line"}, {"transport", "serial"}, {"port", "/dev/ttyUSB0"}},
                                  {{"name", "D"}, {"address", "1"}}};

inline Loaded project_of(const std::string& table, const TableOptions& options = {}) {
    return project_of_table(load_table_text("t.csv", table, options), kAround);
}

inline std::vector<model::Variable> variables_of(const model::Project& project) {
    std::vector<model::Variable> all;
    for (const auto& line : project.lines)
        for (const auto& device : line.devices)
            all.insert(all.end(), device.variables.begin(), device.variables.end());
    return all;
}

inline std::string local_name(const model::Project& project, const std::optional<model::LocalIndex>& local) {
    return local ? project.locals[*local].name : std::string("none");
}

/// All properties of a variable as text; locals by their names.
inline std::string described(const model::Project& project, const model::Variable& v) {
    std::string text = v.name + "|" + v.unit + "|" + v.comment + "|";
    for (const auto& tag : v.tags) text += tag + ",";
    const auto add = [&](auto value) { text += testing::PrintToString(value) + "|"; };
    add(v.type);
    add(v.area);
    add(v.register_number);
    add(v.bit.value_or(99));
    add(v.registers);
    add(v.read ? static_cast<int>(*v.read) : -1);
    add(v.write ? static_cast<int>(*v.write) : -1);
    add(v.write_on_change);
    for (const auto& local : {v.read_trigger, v.write_trigger, v.status})
        text += local_name(project, local) + "|";
    if (v.admission) add(std::pair(v.admission->min_interval.count(), v.admission->burst));
    add(v.period.count());
    add(v.deadline ? v.deadline->count() : -1);
    if (v.default_value) {
        text += v.default_value->text + "|";
        add(v.default_value->number);
        add(v.default_value->integer);
    }
    for (const bool flag : {v.hold_last, v.retain, v.used, v.verify, v.safe_to_repeat,
                            v.order.high_byte_first, v.order.high_register_first})
        add(flag);
    const auto range = v.write_range.value_or(model::WriteRange{});
    for (const double number : {v.scale, v.offset, v.dead_band, range.least, range.greatest})
        text += fmt::format("{}|", number);
    return text;
}

inline std::vector<std::string> described(const model::Project& project) {
    std::vector<std::string> all;
    for (const auto& variable : variables_of(project)) all.push_back(described(project, variable));
    return all;
}

}  // namespace takt::file
