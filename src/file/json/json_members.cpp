#include "takt/file/json_members.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

namespace takt::file {

const Json& member(const Json& object, std::string_view key) {
    static const Json kNull;
    const auto* const found = object.find(key);
    return found ? *found : kNull;
}

const std::string* text_in(const Json& value) {
    return std::get_if<std::string>(&value.value());
}

const Json::Array& items_of(const Json& value) {
    static const Json::Array kNone;
    const auto* const items = std::get_if<Json::Array>(&value.value());
    return items ? *items : kNone;
}

std::string scalar_text(const Json& value) {
    if (value.is_null()) return {};
    const auto* const text = text_in(value);
    return text ? *text : value.dump();
}

std::string string_member(const Json& object, std::string_view key, std::string_view otherwise) {
    const auto* const text = text_in(member(object, key));
    return text ? *text : std::string(otherwise);
}

std::optional<double> number_member(const Json& object, std::string_view key) {
    const auto& value = member(object, key).value();
    if (const auto* const n = std::get_if<double>(&value)) return *n;
    if (const auto* const n = std::get_if<std::int64_t>(&value)) return static_cast<double>(*n);
    if (const auto* const n = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*n);
    return std::nullopt;
}

std::optional<std::int64_t> whole_member(const Json& object, std::string_view key) {
    const auto& value = member(object, key).value();
    if (const auto* const n = std::get_if<std::int64_t>(&value)) return *n;
    if (const auto* const n = std::get_if<std::uint64_t>(&value))
        return static_cast<std::int64_t>(std::min<std::uint64_t>(*n, INT64_MAX));
    return std::nullopt;
}

bool flag_member(const Json& object, std::string_view key, bool otherwise) {
    const auto* const flag = std::get_if<bool>(&member(object, key).value());
    return flag ? *flag : otherwise;
}

std::string count_member(const Json& object, std::string_view key) {
    return fmt::format("{:.0f}", number_member(object, key).value_or(0));
}

std::optional<Duration> time_member(const Json& object, std::string_view key) {
    constexpr double kMostMs = 1e12;  // far from the limit of Duration
    const auto ms = number_member(object, key);
    if (!ms) return std::nullopt;
    return Duration(static_cast<std::int64_t>(std::clamp(*ms, 0.0, kMostMs) * 1e6));
}

const Json::Array& array_member(const Json& object, std::string_view key) {
    return items_of(member(object, key));
}

std::vector<std::string> strings_member(const Json& object, std::string_view key) {
    std::vector<std::string> texts;
    for (const auto& item : array_member(object, key))
        if (const auto* const text = text_in(item)) texts.push_back(*text);
    return texts;
}

}  // namespace takt::file
