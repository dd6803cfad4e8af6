#include "json_members.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

namespace takt::report {

const file::Json& member(const file::Json& object, std::string_view key) {
    static const file::Json kNull;
    const auto* const found = object.find(key);
    return found ? *found : kNull;
}

std::string string_member(const file::Json& object, std::string_view key) {
    const auto* const text = std::get_if<std::string>(&member(object, key).value());
    return text ? *text : std::string();
}

std::optional<double> number_member(const file::Json& object, std::string_view key) {
    const auto& value = member(object, key).value();
    if (const auto* const n = std::get_if<double>(&value)) return *n;
    if (const auto* const n = std::get_if<std::int64_t>(&value)) return static_cast<double>(*n);
    if (const auto* const n = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*n);
    return std::nullopt;
}

std::string count_member(const file::Json& object, std::string_view key) {
    return fmt::format("{:.0f}", number_member(object, key).value_or(0));
}

std::optional<Duration> time_member(const file::Json& object, std::string_view key) {
    constexpr double kMostMs = 1e12;  // far from the limit of Duration
    const auto ms = number_member(object, key);
    if (!ms) return std::nullopt;
    return Duration(static_cast<std::int64_t>(std::clamp(*ms, 0.0, kMostMs) * 1e6));
}

const file::Json::Array& array_member(const file::Json& object, std::string_view key) {
    static const file::Json::Array kNone;
    const auto* const array = std::get_if<file::Json::Array>(&member(object, key).value());
    return array ? *array : kNone;
}

}  // namespace takt::report
