#include "take_over.hpp"

#include <charconv>
#include <cstddef>
#include <iterator>
#include <utility>

#include "takt/file/edit.hpp"

namespace takt::web {
namespace {

using file::Json;

constexpr std::string_view kTemplate = "device_template";
constexpr std::string_view kParameters = "parameters";
constexpr std::string_view kVariables = "variables";

/// The value at "lines[0].devices[2].variables"; nullptr: there is none.
const Json* node_at(const Json& root, std::string_view path) {
    const Json* its = &root;
    while (its != nullptr && !path.empty()) {
        if (path.starts_with('[')) {
            std::size_t index = 0;
            const auto [end, error] = std::from_chars(path.data() + 1, path.data() + path.size(), index);
            const auto* const items = std::get_if<Json::Array>(&its->value());
            if (error != std::errc() || end == path.data() + path.size() || *end != ']') return nullptr;
            its = items != nullptr && index < items->size() ? &(*items)[index] : nullptr;
            path.remove_prefix(static_cast<std::size_t>(end - path.data()) + 1);
        } else {
            if (path.starts_with('.')) path.remove_prefix(1);
            const auto key = path.substr(0, path.find_first_of(".["));
            its = its->find(key);
            path.remove_prefix(key.size());
            if (key.empty()) return nullptr;
        }
    }
    return its;
}

/// A copy without the places that its parts have in a file.
Json as_new(const Json& json) {
    if (const auto* const items = std::get_if<Json::Array>(&json.value())) {
        Json::Array copy;
        for (const auto& item : *items) copy.push_back(as_new(item));
        return Json(std::move(copy));
    }
    const auto* const entries = std::get_if<Json::Object>(&json.value());
    if (entries == nullptr) return json;
    Json::Object copy;
    for (const auto& [key, value] : *entries)
        if (key != file::kOriginKey) copy.emplace_back(key, as_new(value));
    return Json(std::move(copy));
}

bool is_name_text(const Json* json) {
    return json != nullptr && std::holds_alternative<std::string>(json->value());
}

Json::Array items_of(const Json* list) {
    const auto* const items = list == nullptr ? nullptr : std::get_if<Json::Array>(&list->value());
    return items == nullptr ? Json::Array{} : *items;
}

/// The rows of the template go before those of the device.
Json variables_of(const Json& own, const Json& complete) {
    auto mine = items_of(own.find(kVariables));
    auto rows = items_of(complete.find(kVariables));
    if (rows.size() >= mine.size()) rows.resize(rows.size() - mine.size());
    for (auto& row : rows) row = as_new(row);
    rows.insert(rows.end(), std::make_move_iterator(mine.begin()), std::make_move_iterator(mine.end()));
    return Json(std::move(rows));
}

Json device_without_template(const Json& own, const Json& complete) {
    const auto is_replaced = [](std::string_view key) {
        return key == kTemplate || key == kParameters || key == kVariables || key == file::kOriginKey;
    };
    auto device = Json::object();
    for (const auto& [key, value] : std::get<Json::Object>(own.value()))
        if (!is_replaced(key)) device.set(key, value);
    for (const auto& [key, value] : std::get<Json::Object>(complete.value()))
        if (!is_replaced(key) && own.find(key) == nullptr) device.set(key, as_new(value));
    device.set(kVariables, variables_of(own, complete));
    if (const auto* const from = own.find(file::kOriginKey)) device.set(file::kOriginKey, *from);
    return device;
}

}  // namespace

std::optional<TakenOver> taken_over(const Json& own, const Json& complete, std::string_view path) {
    if (!is_name_text(node_at(own, path))) return std::nullopt;
    const auto dot = path.rfind('.');
    const auto key = path.substr(dot == std::string_view::npos ? 0 : dot + 1);
    if (key == kVariables || path == "locals") {
        const auto* const list = node_at(complete, path);
        if (list == nullptr || !std::holds_alternative<Json::Array>(list->value())) return std::nullopt;
        return TakenOver{std::string(path), as_new(*list)};
    }
    if (key != kTemplate || dot == std::string_view::npos) return std::nullopt;
    const auto owner = path.substr(0, dot);
    const auto* const mine = node_at(own, owner);
    const auto* const whole = node_at(complete, owner);
    if (mine == nullptr || whole == nullptr || !std::holds_alternative<Json::Object>(whole->value()))
        return std::nullopt;
    return TakenOver{std::string(owner), device_without_template(*mine, *whole)};
}

}  // namespace takt::web
