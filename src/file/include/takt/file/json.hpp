// JSON values, for --json output and for files that are read with limits.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "takt/base/result.hpp"

namespace takt::file {

/// One JSON value: null, bool, number, text, list, or an object that keeps the order of its keys.
///
///     auto object = Json::object();
///     object.set("name", device.name);
///     object.set("period_ms", 12.5);
///
/// Integers keep all 64 bits. Copies are deep.
class Json {
public:
    using Array = std::vector<Json>;
    using Object = std::vector<std::pair<std::string, Json>>;
    using Value =
        std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, Array, Object>;

    // NOLINTBEGIN(*-explicit-*): each of these is a JSON value
    Json() = default;
    Json(std::same_as<bool> auto flag) : value_(flag) {}
    Json(std::signed_integral auto number) : value_(std::int64_t{number}) {}
    Json(std::unsigned_integral auto number)
        requires(!std::same_as<decltype(number), bool>)
        : value_(std::uint64_t{number}) {}
    Json(double number) : value_(number) {}
    Json(float number);  ///< the shortest decimal number that is this float: 0.1, not 0.10000000149011612
    Json(std::string text) : value_(std::move(text)) {}
    Json(std::string_view text) : value_(std::string(text)) {}
    Json(const char* text) : value_(std::string(text)) {}
    // NOLINTEND(*-explicit-*)
    explicit Json(Array items) : value_(std::move(items)) {}
    explicit Json(Object entries) : value_(std::move(entries)) {}  ///< each key once

    [[nodiscard]] static Json array() { return Json(Array{}); }
    [[nodiscard]] static Json object() { return Json(Object{}); }

    /// Appends a key to an object, or replaces its value. Linear in the number of keys; for thousands of keys
    /// build an Object.
    void set(std::string_view key, Json value);
    /// Appends an item to a list.
    void push_back(Json item);

    [[nodiscard]] const Value& value() const { return value_; }
    /// The value of a key; nullptr if there is none or this is no object.
    [[nodiscard]] const Json* find(std::string_view key) const;

    /// The value as text: in one line, or with `indent` >= 0 in indented lines. Numbers have the shortest
    /// form that reads back equal; numbers that are not finite become null. Invalid UTF-8 becomes U+FFFD.
    [[nodiscard]] std::string dump(int indent = -1) const;

    /// Parses one value. Refused: more than `max_bytes`, nesting deeper than kMaxDepth, duplicate keys,
    /// numbers beyond a double, text after the value.
    /// @returns too_long (bytes there, allowed); syntax (the parser's words, offset of the byte)
    [[nodiscard]] static Result<Json> parse(std::string_view text,
                                            std::size_t max_bytes = std::size_t{1} << 20);
    static constexpr std::size_t kMaxDepth = 64;

    friend bool operator==(const Json&, const Json&) = default;

private:
    Value value_;
};

}  // namespace takt::file
