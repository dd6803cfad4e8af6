#include "takt/report/plan_csv.hpp"

#include <array>
#include <string_view>

#include "takt/report/formatting.hpp"

namespace takt::report {
namespace {

using file::Json;

constexpr std::array<std::string_view, 14> kKeys{
    "device",    "unit",         "function",      "write_function",  "start",       "quantity", "variables",
    "period_ms", "read_trigger", "write_trigger", "write_on_change", "bus_time_us", "share",    "why"};

std::string cell_text(const Json* value) {
    if (value == nullptr || value->is_null()) return "";
    if (const auto* const text = std::get_if<std::string>(&value->value())) return *text;
    const auto* const items = std::get_if<Json::Array>(&value->value());
    if (items == nullptr) return value->dump();
    std::string joined;
    for (const auto& item : *items) joined += (joined.empty() ? "" : "; ") + cell_text(&item);
    return joined;
}

const Json::Array& list_at(const Json& object, std::string_view key) {
    static const Json::Array kNone;
    const auto* const found = object.find(key);
    const auto* const list = found == nullptr ? nullptr : std::get_if<Json::Array>(&found->value());
    return list == nullptr ? kNone : *list;
}

}  // namespace

std::string plan_csv(const Json& plan) {
    std::string text = "line";
    for (const auto key : kKeys) text += "," + std::string(key);
    text += "\r\n";
    for (const auto& line : list_at(plan, "lines"))
        for (const auto& request : list_at(line, "requests")) {
            text += csv_cell(cell_text(line.find("name")), ',');
            for (const auto key : kKeys) text += "," + csv_cell(cell_text(request.find(key)), ',');
            text += "\r\n";
        }
    return text;
}

}  // namespace takt::report
