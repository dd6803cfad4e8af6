// JSON values: built for --json and read with limits.
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

/// One JSON value: nothing (null), a bool, a number, a text, a list or an object whose keys keep their order.
///
///     auto object = Json::object();
///     object.set("name", device.name);
///     object.set("period_ms", 12.5);
///
/// Whole numbers keep all their 64 bits. Copies are deep.
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

    /// Adds a key at the end of an object, or gives the one that is there another value. Looks through all
    /// keys: for objects of thousands, make an Object.
    void set(std::string_view key, Json value);
    /// Adds an item at the end of a list.
    void push_back(Json item);

    [[nodiscard]] const Value& value() const { return value_; }
    [[nodiscard]] bool is_null() const { return std::holds_alternative<std::monostate>(value_); }
    /// The value of a key; nullptr when there is none or this is no object.
    [[nodiscard]] const Json* find(std::string_view key) const;

    /// The value as text: in one line, or with `indent` >= 0 in lines indented by so many spaces. Numbers are
    /// as short as they can be to be read back the same, those that are not finite become null; bytes that
    /// are not UTF-8 become U+FFFD.
    [[nodiscard]] std::string dump(int indent = -1) const;

    /// Reads one value. Refused: more than `max_bytes`, lists and objects inside one another deeper than
    /// kMaxDepth, keys that are there twice, numbers too great for a double, anything after the value.
    /// Errors: too_long (bytes there, allowed); syntax with the parser's words as subject and the offset of
    /// the byte.
    [[nodiscard]] static Result<Json> parse(std::string_view text,
                                            std::size_t max_bytes = std::size_t{1} << 20);
    static constexpr std::size_t kMaxDepth = 64;

    friend bool operator==(const Json&, const Json&) = default;

private:
    Value value_;
};

}  // namespace takt::file
