#include "takt/report/plans/plan_csv.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "takt/file/json_members.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace {

using file::Json;

std::string cell_text(const Json& value) {
    if (!std::holds_alternative<Json::Array>(value.value())) return scalar_text(value);
    std::string joined;
    for (const auto& item : items_of(value))
        joined += (&item == items_of(value).data() ? "" : "; ") + cell_text(item);
    return joined;
}

// The keys of all requests, in the order in which they occur.
std::vector<std::string> columns_of(const Json& plan) {
    std::vector<std::string> columns;
    for (const auto& line : array_member(plan, "lines"))
        for (const auto& request : array_member(line, "requests"))
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
    for (const auto& line : array_member(plan, "lines"))
        for (const auto& request : array_member(line, "requests")) {
            text += csv_cell(cell_text(member(line, "name")), ',');
            for (const auto& key : columns) text += "," + csv_cell(cell_text(member(request, key)), ',');
            text += "\r\n";
        }
    return text;
}

}  // namespace takt::report
