// Numbers: the registers form one integer, least significant register first, which is then interpreted by
// type. Strings are copied byte by byte.
#include "takt/value/codec.hpp"

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <limits>

#include "scaling.hpp"

namespace takt::value {
namespace {

constexpr std::uint16_t swapped(std::uint16_t word) {
    return static_cast<std::uint16_t>(word << 8 | word >> 8);
}

std::uint16_t in_order(std::uint16_t word, ByteOrder order) {
    return order.high_byte_first ? word : swapped(word);
}

std::uint64_t gather(ByteOrder order, std::span<const std::uint16_t> registers) {
    std::uint64_t raw = 0;
    for (std::size_t i = 0; i < registers.size(); ++i) {
        const std::size_t rank = order.high_register_first ? registers.size() - 1 - i : i;
        raw |= std::uint64_t{in_order(registers[i], order)} << (16 * rank);
    }
    return raw;
}

void scatter(ByteOrder order, std::uint64_t raw, std::size_t count,
             InplaceVector<std::uint16_t, 125>& registers) {
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t rank = order.high_register_first ? count - 1 - i : i;
        registers.push_back(in_order(static_cast<std::uint16_t>(raw >> (16 * rank)), order));
    }
}

std::string decode_text(ByteOrder order, std::span<const std::uint16_t> registers) {
    std::string text;
    for (const auto word : registers) {
        const std::uint16_t ordered = in_order(word, order);
        for (const int shift : {8, 0}) {
            const auto byte = static_cast<char>(ordered >> shift & 0xFF);
            if (byte == '\0') return text;
            text += byte;
        }
    }
    return text;
}

/// The bits and signedness of an integer type.
struct IntegerRange {
    bool is_signed;
    int bits;
    [[nodiscard]] std::uint64_t greatest() const {
        return ~std::uint64_t{0} >> (64 - bits + (is_signed ? 1 : 0));
    }
    [[nodiscard]] std::uint64_t least_magnitude() const { return is_signed ? greatest() + 1 : 0; }
};

std::optional<IntegerRange> integer_range(DataType type) {
    switch (type) {
        case DataType::int16: return IntegerRange{true, 16};
        case DataType::uint16: return IntegerRange{false, 16};
        case DataType::int32: return IntegerRange{true, 32};
        case DataType::uint32: return IntegerRange{false, 32};
        case DataType::int64: return IntegerRange{true, 64};
        case DataType::uint64: return IntegerRange{false, 64};
        default: return std::nullopt;
    }
}

/// An integer as sign and 64-bit magnitude.
struct Whole {
    bool negative = false;
    std::uint64_t magnitude = 0;
    bool rounded = false;
};

Result<Whole> whole_of(double number) {
    if (!std::isfinite(number)) return fail(Code::out_of_range);
    const double nearest = std::round(number);
    if (std::abs(nearest) >= 18446744073709551616.0) return fail(Code::overflow);
    return Whole{nearest < 0, static_cast<std::uint64_t>(std::abs(nearest)), nearest != number};
}

Result<Whole> whole_of(const Value& value) {
    if (const auto* on = std::get_if<bool>(&value)) return Whole{false, *on ? 1U : 0U, false};
    if (const auto* i = std::get_if<std::int64_t>(&value))
        return Whole{*i < 0, *i < 0 ? ~static_cast<std::uint64_t>(*i) + 1 : static_cast<std::uint64_t>(*i),
                     false};
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return Whole{false, *u, false};
    if (const auto* d = std::get_if<double>(&value)) return whole_of(*d);
    return fail(Code::unsupported);
}

/// The two's complement bits of `whole`, if it is in the range of the type.
Result<std::uint64_t> fit(const IntegerRange& range, const Whole& whole) {
    if (whole.magnitude > (whole.negative ? range.least_magnitude() : range.greatest()))
        return fail(Code::overflow);
    return whole.negative ? ~whole.magnitude + 1 : whole.magnitude;
}

Result<double> double_of(const Value& value) {
    if (const auto* on = std::get_if<bool>(&value)) return *on ? 1.0 : 0.0;
    if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*u);
    if (const auto* d = std::get_if<double>(&value)) return *d;
    return fail(Code::unsupported);
}

Result<bool> bool_of(const Value& value) {
    TAKT_TRY(const Whole whole, whole_of(value));
    if (whole.magnitude > 1 || whole.negative || whole.rounded) return fail(Code::overflow);
    return whole.magnitude == 1;
}

double raw_number(const Layout& layout, std::uint64_t raw) {
    switch (layout.type) {
        case DataType::int16: return static_cast<std::int16_t>(raw);
        case DataType::int32: return static_cast<std::int32_t>(raw);
        case DataType::int64: return static_cast<double>(static_cast<std::int64_t>(raw));
        case DataType::float32: return std::bit_cast<float>(static_cast<std::uint32_t>(raw));
        case DataType::float64: return std::bit_cast<double>(raw);
        default: return static_cast<double>(raw);
    }
}

Result<float> float_of(double number) {
    // Beyond the midpoint between FLT_MAX and the next power of two the conversion is undefined behaviour.
    if (std::isfinite(number) && std::abs(number) >= 0x1.FFFFFFp127) return fail(Code::overflow);
    return static_cast<float>(number);
}

/// Rounding that the scaling itself causes is not reported as a loss.
bool differs(double read_back, double wanted, double offset) {
    if (std::isnan(read_back) || std::isnan(wanted)) return std::isnan(read_back) != std::isnan(wanted);
    if (read_back == wanted) return false;
    return !(std::abs(read_back - wanted) <= 8 * DBL_EPSILON * std::max(std::abs(wanted), std::abs(offset)));
}

Result<Encoded> encode_scaled_integer(const Layout& layout, const IntegerRange& range, double number) {
    if (!std::isfinite(number)) return fail(Code::out_of_range);
    const Scaling scaling(layout.scale, layout.offset);
    const double raw = scaling.whole_inverse(number);
    TAKT_TRY(const Whole whole, whole_of(raw));
    TAKT_TRY(const std::uint64_t bits, fit(range, whole));
    Encoded encoded;
    encoded.rounded = scaling.value(raw) != number;
    scatter(layout.order, bits, static_cast<std::size_t>(layout.register_count()), encoded.registers);
    return encoded;
}

Result<Encoded> encode_integer(const Layout& layout, const IntegerRange& range, const Value& value) {
    if (layout.scaled()) {
        TAKT_TRY(const double number, double_of(value));
        return encode_scaled_integer(layout, range, number);
    }
    TAKT_TRY(const Whole whole, whole_of(value));
    TAKT_TRY(const std::uint64_t bits, fit(range, whole));
    Encoded encoded;
    encoded.rounded = whole.rounded;
    scatter(layout.order, bits, static_cast<std::size_t>(layout.register_count()), encoded.registers);
    return encoded;
}

Result<Encoded> encode_floating(const Layout& layout, const Value& value) {
    TAKT_TRY(const double wanted, double_of(value));
    const Scaling scaling(layout.scale, layout.offset);
    double raw = layout.scaled() ? scaling.inverse(wanted) : wanted;
    if (std::isfinite(wanted) && !std::isfinite(raw)) return fail(Code::overflow);
    Encoded encoded;
    std::uint64_t bits = std::bit_cast<std::uint64_t>(raw);
    if (layout.type == DataType::float32) {
        TAKT_TRY(const float single, float_of(raw));
        raw = single;
        bits = std::bit_cast<std::uint32_t>(single);
    }
    encoded.rounded = layout.scaled() ? differs(scaling.value(raw), wanted, layout.offset)
                                      : raw != wanted && !(std::isnan(raw) && std::isnan(wanted));
    scatter(layout.order, bits, static_cast<std::size_t>(layout.register_count()), encoded.registers);
    return encoded;
}

Result<Encoded> encode_bool(const Layout& layout, const Value& value) {
    TAKT_TRY(const bool on, bool_of(value));
    Encoded encoded;
    scatter(layout.order, on ? std::uint64_t{1} << layout.bit.value_or(0) : 0, 1, encoded.registers);
    return encoded;
}

Result<Encoded> encode_text(const Layout& layout, const Value& value) {
    const auto* text = std::get_if<std::string>(&value);
    if (!text) return fail(Code::unsupported);
    if (text->size() > std::size_t{layout.registers} * 2) return fail(Code::overflow);
    Encoded encoded;
    const std::size_t end = std::min(text->find('\0'), text->size());
    const auto byte = [&](std::size_t i) { return i < end ? static_cast<std::uint8_t>((*text)[i]) : 0U; };
    for (std::size_t i = 0; i < layout.registers; ++i)
        encoded.registers.push_back(
            in_order(static_cast<std::uint16_t>(byte(2 * i) << 8 | byte(2 * i + 1)), layout.order));
    encoded.rounded = end < text->size();
    return encoded;
}

}  // namespace

std::uint16_t register_mask(const Layout& layout) {
    if (layout.type != DataType::boolean || !layout.bit) return 0xFFFF;
    return in_order(static_cast<std::uint16_t>(1U << *layout.bit), layout.order);
}

Result<Value> decode(const Layout& layout, std::span<const std::uint16_t> registers) {
    const auto needed = static_cast<std::size_t>(layout.register_count());
    if (registers.size() < needed)
        return fail(Code::too_short, static_cast<std::int64_t>(registers.size()),
                    static_cast<std::int64_t>(needed));
    registers = registers.first(needed);
    if (layout.type == DataType::string) return decode_text(layout.order, registers);
    const std::uint64_t raw = gather(layout.order, registers);
    if (layout.type == DataType::boolean) return layout.bit ? (raw >> *layout.bit & 1) != 0 : raw != 0;
    if (layout.scaled()) return Scaling(layout.scale, layout.offset).value(raw_number(layout, raw));
    switch (layout.type) {
        case DataType::int16: return std::int64_t{static_cast<std::int16_t>(raw)};
        case DataType::int32: return std::int64_t{static_cast<std::int32_t>(raw)};
        case DataType::int64: return static_cast<std::int64_t>(raw);
        case DataType::float32:
        case DataType::float64: return raw_number(layout, raw);
        default: return raw;
    }
}

Result<Encoded> encode(const Layout& layout, const Value& value) {
    if (layout.type == DataType::string) return encode_text(layout, value);
    if (layout.type == DataType::boolean) return encode_bool(layout, value);
    if (const auto range = integer_range(layout.type)) return encode_integer(layout, *range, value);
    return encode_floating(layout, value);
}

Result<Value> convert(DataType type, bool scaled, const Value& value) {
    if (type == DataType::string) {
        if (!std::holds_alternative<std::string>(value)) return fail(Code::unsupported);
        return value;
    }
    if (type == DataType::boolean) return bool_of(value);
    if (const auto range = integer_range(type); range && !scaled) {
        TAKT_TRY(const Whole whole, whole_of(value));
        if (whole.rounded) return fail(Code::out_of_range);
        TAKT_TRY(const std::uint64_t bits, fit(*range, whole));
        return range->is_signed ? Value(static_cast<std::int64_t>(bits)) : Value(bits);
    }
    TAKT_TRY(const double number, double_of(value));
    if (type != DataType::float32 || scaled) return number;
    TAKT_TRY(const float single, float_of(number));
    return double{single};
}

}  // namespace takt::value
