#include "project/take_over.hpp"

#include <charconv>
#include <cstddef>
#include <iterator>
#include <utility>

#include "takt/file/document_json.hpp"
#include "takt/file/edit.hpp"
#include "takt/file/json_members.hpp"

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

/// The rows of the template go before those of the device.
Json variables_of(const Json& own, const Json& complete) {
    auto mine = array_member(own, kVariables);
    auto rows = array_member(complete, kVariables);
    if (rows.size() >= mine.size()) rows.resize(rows.size() - mine.size());
    for (auto& row : rows) row = file::without_origins(row);
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
        if (!is_replaced(key) && own.find(key) == nullptr) device.set(key, file::without_origins(value));
    device.set(kVariables, variables_of(own, complete));
    if (const auto* const from = own.find(file::kOriginKey)) device.set(file::kOriginKey, *from);
    return device;
}

}  // namespace

std::optional<TakenOver> taken_over(const Json& own, const Json& complete, std::string_view path) {
    const auto* const name = node_at(own, path);
    if (name == nullptr || !text_in(*name)) return std::nullopt;
    const auto dot = path.rfind('.');
    const auto key = path.substr(dot == std::string_view::npos ? 0 : dot + 1);
    if (key == kVariables || path == "locals") {
        const auto* const list = node_at(complete, path);
        if (list == nullptr || !std::holds_alternative<Json::Array>(list->value())) return std::nullopt;
        return TakenOver{std::string(path), file::without_origins(*list)};
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
