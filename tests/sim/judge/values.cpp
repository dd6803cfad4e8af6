#include "values.hpp"

#include <bit>
#include <cmath>
#include <cstdio>

namespace takt::judge {
namespace {

using value::Value;

unsigned ordered(const model::Variable& variable, std::uint16_t item) {
    return variable.order.high_byte_first ? item : static_cast<unsigned>(item >> 8U | (item & 0xFFU) << 8U);
}

std::uint64_t whole(const model::Variable& variable, std::span<const std::uint16_t> items) {
    std::uint64_t number = 0;
    const std::size_t count = variable.registers;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t place = variable.order.high_register_first ? i : count - 1 - i;
        number = number << 16U | ordered(variable, items[place]);
    }
    return number;
}

std::string characters(const model::Variable& variable, std::span<const std::uint16_t> items) {
    std::string made;
    for (const auto item : items.first(variable.registers))
        for (const unsigned shift : {8U, 0U}) {
            const auto byte = static_cast<char>(ordered(variable, item) >> shift & 0xFFU);
            if (byte == '\0') return made;
            made += byte;
        }
    return made;
}

double number_of(DataType type, std::uint64_t raw) {
    switch (type) {
        case DataType::int16: return static_cast<std::int16_t>(raw);
        case DataType::int32: return static_cast<std::int32_t>(raw);
        case DataType::int64: return static_cast<double>(static_cast<std::int64_t>(raw));
        case DataType::float32: return std::bit_cast<float>(static_cast<std::uint32_t>(raw));
        case DataType::float64: return std::bit_cast<double>(raw);
        default: return static_cast<double>(raw);
    }
}

bool is_whole(DataType type) {
    return type != DataType::float32 && type != DataType::float64;
}

double as_number(const Value& value) {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*u);
    if (const auto* b = std::get_if<bool>(&value)) return *b ? 1 : 0;
    if (const auto* d = std::get_if<double>(&value)) return *d;
    return std::nan("");
}

}  // namespace

Value value_of(const model::Variable& variable, std::span<const std::uint16_t> items) {
    const bool in_register = !wire::is_bit_area(variable.area);
    if (variable.type == DataType::boolean) {
        const std::uint64_t raw = in_register ? whole(variable, items) : items[0];
        return in_register && variable.bit ? (raw >> *variable.bit & 1U) != 0 : raw != 0;
    }
    if (variable.type == DataType::string) return characters(variable, items);
    const std::uint64_t raw = whole(variable, items);
    const double number = number_of(variable.type, raw);
    if (variable.scaled()) return number * variable.scale + variable.offset;
    switch (variable.type) {
        case DataType::int16: return std::int64_t{static_cast<std::int16_t>(raw)};
        case DataType::int32: return std::int64_t{static_cast<std::int32_t>(raw)};
        case DataType::int64: return static_cast<std::int64_t>(raw);
        case DataType::float32:
        case DataType::float64: return number;
        default: return raw;
    }
}

bool equal(const Value& a, const Value& b) {
    if (a.index() != b.index()) return false;
    const auto* x = std::get_if<double>(&a);
    if (!x) return a == b;
    const double y = std::get<double>(b);
    return (std::isnan(*x) && std::isnan(y)) || (*x == y && std::signbit(*x) == std::signbit(y));
}

bool holds(const model::Variable& variable, std::span<const std::uint16_t> items, const Value& shown,
           bool rounding) {
    const Value held = value_of(variable, items);
    const bool exact = variable.type == DataType::boolean || variable.type == DataType::string ||
                       (is_whole(variable.type) && !variable.scaled());
    if (exact && (held.index() == shown.index() || !rounding)) return held == shown;
    if (variable.type == DataType::string) return false;
    const double a = as_number(held);
    const double b = as_number(shown);
    if (std::isnan(a) || std::isnan(b)) return std::isnan(a) == std::isnan(b);
    if (std::isinf(a) || std::isinf(b)) return a == b;
    const bool rounds = rounding && variable.type != DataType::float64;
    if (!rounds && !variable.scaled()) return equal(held, shown);
    const double size = std::max(std::abs(a), std::abs(b)) + std::abs(variable.offset);
    double allowed = size * 1e-12;
    if (rounding && is_whole(variable.type)) allowed += std::abs(variable.scale) * 0.500001;
    if (rounding && variable.type == DataType::float32)
        allowed += size * 1e-6 + std::abs(variable.scale) * 1e-38;
    return std::abs(a - b) <= allowed;
}

std::string text(const Value& value) {
    char buffer[64];
    if (const auto* s = std::get_if<std::string>(&value)) {
        std::string made = "\"";
        for (const char c : *s) {
            std::snprintf(buffer, sizeof buffer, "\\x%02X", static_cast<unsigned char>(c));
            made += c >= ' ' && c < 127 ? std::string(1, c) : buffer;
        }
        return made + "\"";
    }
    if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
    if (const auto* i = std::get_if<std::int64_t>(&value)) return std::to_string(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return std::to_string(*u);
    if (const auto* d = std::get_if<double>(&value)) {
        std::snprintf(buffer, sizeof buffer, "%.17g", *d);
        return buffer;
    }
    return "nothing";
}

std::string text(std::span<const std::uint16_t> items) {
    std::string made;
    char buffer[8];
    for (const auto item : items) {
        std::snprintf(buffer, sizeof buffer, "%s%04X", made.empty() ? "" : " ", item);
        made += buffer;
    }
    return made;
}

std::string milliseconds(Duration time) {
    return std::to_string(time.count() / 1'000'000) + "." +
           std::to_string(1000 + time.count() / 1000 % 1000).substr(1) + " ms";
}

}  // namespace takt::judge
