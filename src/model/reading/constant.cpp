#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "servers/interpretation.hpp"
#include "takt/base/ascii.hpp"

namespace takt::model {
namespace {

struct Limits {
    Integer least;
    std::uint64_t greatest = 0;
};

/// Range of an integer type.
Limits limits(DataType type) {
    const int bits = 16 * register_count(type);
    const std::uint64_t all = ~std::uint64_t{0} >> (64 - bits);
    const bool is_signed = type == DataType::int16 || type == DataType::int32 || type == DataType::int64;
    if (is_signed) return {{all / 2 + 1, true}, all / 2};
    return {{}, all};
}

std::string range_text(const Limits& limits) {
    return (limits.least.negative ? "-" : "") + std::to_string(limits.least.magnitude) + ".." +
           std::to_string(limits.greatest);
}

void report_range(Reader& reader, std::string_view key, DataType type, std::string allowed) {
    reader.report(Rule::default_out_of_range, key, std::move(allowed), {{"type", std::string(name(type))}});
}

std::optional<Constant> read_bool(Reader& reader, std::string_view key, const Node& node) {
    if (!is_quoted(node)) {
        if (node.text == "0" || node.text == "1")
            return Constant{.number = node.text == "1" ? 1.0 : 0.0, .integer = node.text == "1"};
        if (const auto value = parse_bool(node.text))
            return Constant{.number = *value ? 1.0 : 0.0, .integer = *value};
    }
    reader.report(Rule::boolean_malformed, key, "true, false, 0, 1");
    return std::nullopt;
}

std::optional<Constant> read_integer(Reader& reader, std::string_view key, const Node& node, DataType type) {
    const auto bounds = limits(type);
    const auto parsed = parse_integer(node.text);
    if (!parsed && parsed.error() != ScalarError::too_large) {
        const auto rule = parsed.error() == ScalarError::fraction       ? Rule::integer_fraction
                          : parsed.error() == ScalarError::leading_zero ? Rule::integer_leading_zero
                                                                        : Rule::integer_malformed;
        reader.report(rule, key, range_text(bounds));
        return std::nullopt;
    }
    if (!parsed || parsed->magnitude > (parsed->negative ? bounds.least.magnitude : bounds.greatest)) {
        report_range(reader, key, type, range_text(bounds));
        return std::nullopt;
    }
    const auto bits = parsed->negative ? 0 - parsed->magnitude : parsed->magnitude;
    const auto magnitude = static_cast<double>(parsed->magnitude);
    return Constant{.number = parsed->negative ? -magnitude : magnitude,
                    .integer = static_cast<std::int64_t>(bits)};
}

/// The range of a variable's values: that of its type on the wire, scaled.
std::pair<double, double> span_of(const ConstantShape& shape) {
    double least = -std::numeric_limits<double>::max();
    if (shape.type == DataType::float32) least = -double{std::numeric_limits<float>::max()};
    double greatest = -least;
    if (is_integer(shape.type)) {
        const auto bounds = limits(shape.type);
        least = bounds.least.negative ? -static_cast<double>(bounds.least.magnitude) : 0;
        greatest = static_cast<double>(bounds.greatest);
    }
    least = least * shape.scale + shape.offset;
    greatest = greatest * shape.scale + shape.offset;
    return std::minmax({least, greatest});
}

std::optional<Constant> read_float(Reader& reader, std::string_view key, const Node& node,
                                   const ConstantShape& shape) {
    const auto [least, greatest] = span_of(shape);
    const auto allowed = to_text(least) + ".." + to_text(greatest);
    const auto parsed = parse_number(node.text);
    if (!parsed && parsed.error() != ScalarError::too_large) {
        const bool zero = parsed.error() == ScalarError::leading_zero;
        reader.report(zero ? Rule::integer_leading_zero : Rule::number_malformed, key, allowed);
        return std::nullopt;
    }
    if (!parsed || *parsed < least || *parsed > greatest) {
        report_range(reader, key, shape.type, allowed);
        return std::nullopt;
    }
    return Constant{.number = *parsed};
}

}  // namespace

std::optional<Constant> read_constant(Reader& reader, std::string_view key, const ConstantShape& shape) {
    const Node* const node = reader.scalar(key);
    if (node == nullptr) return std::nullopt;
    if (shape.type == DataType::string) {
        if (node->text.size() <= shape.most_bytes) return Constant{.text = node->text};
        reader.report(Rule::default_too_long, key, "0.." + std::to_string(shape.most_bytes),
                      {{"length", std::to_string(node->text.size())}});
        return std::nullopt;
    }
    if (shape.type == DataType::boolean) return read_bool(reader, key, *node);
    if (is_quoted(*node)) {
        reader.report(Rule::field_quoted_number, key);
        return std::nullopt;
    }
    const bool scaled = shape.scale != 1 || shape.offset != 0;
    if (is_integer(shape.type) && !scaled) return read_integer(reader, key, *node, shape.type);
    return read_float(reader, key, *node, shape);
}

std::optional<WriteRange> read_write_range(Reader& reader, const ConstantShape& shape) {
    constexpr std::string_view kKey = "write_range";
    constexpr std::string_view kPoints = "..";
    const auto text = reader.text(kKey);
    if (!text) return std::nullopt;
    const std::string_view all = *text;
    const auto at = all.find(kPoints);
    WriteRange range;
    bool any = false;
    const auto take = [&](std::string_view bound, double& number) {
        bound = trimmed(bound);
        if (bound.empty()) return true;
        any = true;
        const auto parsed = parse_number(bound);
        if (parsed) number = *parsed;
        return parsed.has_value();
    };
    if (at == std::string_view::npos || !take(all.substr(0, at), range.least) ||
        !take(all.substr(at + kPoints.size()), range.greatest) || !any) {
        reader.report(Rule::variable_write_range_malformed, kKey, "0..120, -5.5..40, 0.., ..120");
        return std::nullopt;
    }
    const auto [least, greatest] = span_of(shape);
    const auto allowed = to_text(least) + ".." + to_text(greatest);
    if (range.least > range.greatest) {
        reader.report(Rule::range_reversed, kKey, allowed);
        return std::nullopt;
    }
    const auto holds = [&](double bound) {
        return std::isinf(bound) || (least <= bound && bound <= greatest);
    };
    if (holds(range.least) && holds(range.greatest)) return range;
    report_range(reader, kKey, shape.type, allowed);
    return std::nullopt;
}

}  // namespace takt::model
