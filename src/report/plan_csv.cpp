#include "takt/report/plan_csv.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "takt/report/formatting.hpp"

namespace takt::report {
namespace {

using file::Json;

std::string cell_text(const Json* value) {
    if (value == nullptr || value->is_null()) return "";
    if (const auto* const text = std::get_if<std::string>(&value->value())) return *text;
    const auto* const items = std::get_if<Json::Array>(&value->value());
    if (items == nullptr) return value->dump();
    std::string joined;
    for (const auto& item : *items) joined += (&item == items->data() ? "" : "; ") + cell_text(&item);
    return joined;
}

const Json::Array& list_at(const Json& object, std::string_view key) {
    static const Json::Array kNone;
    const auto* const found = object.find(key);
    const auto* const list = found == nullptr ? nullptr : std::get_if<Json::Array>(&found->value());
    return list == nullptr ? kNone : *list;
}

// The keys of all requests, in the order in which they occur.
std::vector<std::string> columns_of(const Json& plan) {
    std::vector<std::string> columns;
    for (const auto& line : list_at(plan, "lines"))
        for (const auto& request : list_at(line, "requests"))
            for (const auto& [key, value] : std::get<Json::Object>(request.value()))
                if (std::ranges::find(columns, key) == columns.end()) columns.push_back(key);
    return columns;
}

}  // namespace

std::string plan_csv(const Json& plan) {
    const auto columns = columns_of(plan);
    std::string text = "line";
    for (const auto& key : columns) text += "," + key;
    text += "\r\n";
    for (const auto& line : list_at(plan, "lines"))
        for (const auto& request : list_at(line, "requests")) {
            text += csv_cell(cell_text(line.find("name")), ',');
            for (const auto& key : columns) text += "," + csv_cell(cell_text(request.find(key)), ',');
            text += "\r\n";
        }
    return text;
}

}  // namespace takt::report
