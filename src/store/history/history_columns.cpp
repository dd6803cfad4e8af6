#include "history/history_columns.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <optional>
#include <string_view>

namespace takt::store {
namespace {

constexpr std::array<double, 10> kPowers{1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
constexpr double kExactIntegers = 9007199254740992.0;  // 2^53

enum class RealForm : std::uint8_t {
    decimal,        ///< integers; the decimals follow
    float_decimal,  ///< the same, rounded to the nearest float
    float_bits,
    double_bits,
};

std::uint64_t magnitude(std::int64_t value) {
    return value < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(value)
                     : static_cast<std::uint64_t>(value);
}

double from_decimal(std::int64_t digits, std::size_t decimals, bool is_float) {
    const double value = static_cast<double>(digits) / kPowers[decimals];
    return is_float ? static_cast<double>(static_cast<float>(value)) : value;
}

/// The division of two exact doubles is correctly rounded, so it gives the double nearest to the decimal
/// number. Only a number that is restored exactly, bit for bit, counts.
std::optional<std::int64_t> to_decimal(double value, std::size_t decimals, bool is_float) {
    const double digits = std::nearbyint(value * kPowers[decimals]);
    if (!(std::abs(digits) < kExactIntegers)) return std::nullopt;  // also NaN
    const auto integer = static_cast<std::int64_t>(digits);
    const double restored = from_decimal(integer, decimals, is_float);
    if (std::bit_cast<std::uint64_t>(restored) != std::bit_cast<std::uint64_t>(value)) return std::nullopt;
    return integer;
}

/// Fills `digits` if all numbers have a common number of decimals. @returns it
std::optional<std::size_t> common_decimals(std::span<const double> numbers, bool is_float,
                                           std::vector<std::int64_t>& digits) {
    // A float has seven decimal digits. With more decimals every float would be a decimal, and a long one.
    const std::size_t most = is_float ? 4 : kPowers.size() - 1;
    std::size_t decimals = 0;
    for (const double number : numbers) {
        while (decimals <= most && !to_decimal(number, decimals, is_float)) ++decimals;
        if (decimals > most) return std::nullopt;
    }
    digits.clear();
    for (const double number : numbers) {
        const auto integer = to_decimal(number, decimals, is_float);
        if (!integer) return std::nullopt;
        digits.push_back(*integer);
    }
    return decimals;
}

template <class Bits>
void put_planes(ByteVector& out, std::span<const Bits> numbers) {
    for (std::size_t byte = sizeof(Bits); byte-- > 0;) {
        Bits last = 0;
        for (const Bits bits : numbers) {
            out.push_back(static_cast<std::uint8_t>((bits ^ last) >> 8 * byte));
            last = bits;
        }
    }
}

template <class Bits>
std::vector<Bits> take_planes(VarintReader& in, std::size_t count) {
    const Bytes planes = in.take_bytes(std::uint64_t{count} * sizeof(Bits));
    std::vector<Bits> numbers(in.good() ? count : 0);
    for (std::size_t byte = sizeof(Bits), at = 0; byte-- > 0 && in.good();)
        for (Bits& bits : numbers) bits |= static_cast<Bits>(Bits{planes[at++]} << 8 * byte);
    for (std::size_t i = 1; i < numbers.size(); ++i) numbers[i] ^= numbers[i - 1];
    return numbers;
}

bool is_float(double number) {
    if (std::isnan(number)) return false;  // the conversion may change its payload
    return std::abs(number) <= 3.4028234663852886e38 &&
           static_cast<double>(static_cast<float>(number)) == number;
}

}  // namespace

void put_integers(ByteVector& out, std::span<const std::int64_t> numbers) {
    if (numbers.empty()) return;
    std::uint64_t divisor = 0;
    for (std::size_t i = 1; i < numbers.size() && divisor != 1; ++i)
        divisor = std::gcd(divisor, magnitude(wrapped_difference(numbers[i], numbers[i - 1])));
    if (divisor == 0 || divisor > INT64_MAX) divisor = 1;
    put_signed(out, numbers[0]);
    put_varint(out, divisor);
    for (std::size_t i = 1; i < numbers.size(); ++i)
        put_signed(out, wrapped_difference(numbers[i], numbers[i - 1]) / static_cast<std::int64_t>(divisor));
}

std::vector<std::int64_t> take_integers(VarintReader& in, std::size_t count) {
    std::vector<std::int64_t> numbers;
    if (count == 0) return numbers;
    numbers.reserve(std::min(count, in.left()));
    numbers.push_back(in.take_signed());
    const std::uint64_t divisor = in.take();
    while (numbers.size() < count && in.good()) {
        const auto step = static_cast<std::uint64_t>(in.take_signed()) * divisor;
        numbers.push_back(wrapped_sum(numbers.back(), static_cast<std::int64_t>(step)));
    }
    return numbers;
}

void put_regular(ByteVector& out, std::span<const std::int64_t> numbers) {
    std::int64_t last = 0;
    std::int64_t step = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const std::int64_t next = wrapped_difference(numbers[i], last);
        put_signed(out, wrapped_difference(next, step));
        step = i == 0 ? 0 : next;  // the first number is no step
        last = numbers[i];
    }
}

std::vector<std::int64_t> take_regular(VarintReader& in, std::size_t count) {
    std::vector<std::int64_t> numbers;
    numbers.reserve(std::min(count, in.left()));
    std::int64_t last = 0;
    std::int64_t step = 0;
    while (numbers.size() < count && in.good()) {
        const std::int64_t next = wrapped_sum(step, in.take_signed());
        step = numbers.empty() ? 0 : next;
        last = wrapped_sum(last, next);
        numbers.push_back(last);
    }
    return numbers;
}

void put_reals(ByteVector& out, std::span<const double> numbers) {
    const auto put_form = [&out](RealForm form) { out.push_back(static_cast<std::uint8_t>(form)); };
    const bool floats = std::ranges::all_of(numbers, is_float);
    std::vector<std::int64_t> digits;
    for (const bool as_float : {false, true}) {
        if (as_float && !floats) break;
        const auto decimals = common_decimals(numbers, as_float, digits);
        if (!decimals) continue;
        put_form(as_float ? RealForm::float_decimal : RealForm::decimal);
        out.push_back(static_cast<std::uint8_t>(*decimals));
        return put_integers(out, digits);
    }
    if (floats) {
        put_form(RealForm::float_bits);
        std::vector<std::uint32_t> bits;
        for (const double number : numbers)
            bits.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(number)));
        return put_planes<std::uint32_t>(out, bits);
    }
    put_form(RealForm::double_bits);
    std::vector<std::uint64_t> bits;
    for (const double number : numbers) bits.push_back(std::bit_cast<std::uint64_t>(number));
    put_planes<std::uint64_t>(out, bits);
}

std::vector<double> take_reals(VarintReader& in, std::size_t count) {
    std::vector<double> numbers;
    const Bytes form = in.take_bytes(1);
    if (!in.good()) return numbers;
    switch (static_cast<RealForm>(form[0])) {
        case RealForm::decimal:
        case RealForm::float_decimal: {
            const Bytes decimals = in.take_bytes(1);
            if (in.good() && decimals[0] >= kPowers.size()) in.fail();
            if (!in.good()) break;
            const bool as_float = static_cast<RealForm>(form[0]) == RealForm::float_decimal;
            for (const std::int64_t digits : take_integers(in, count))
                numbers.push_back(from_decimal(digits, decimals[0], as_float));
            break;
        }
        case RealForm::float_bits:
            for (const auto bits : take_planes<std::uint32_t>(in, count))
                numbers.push_back(static_cast<double>(std::bit_cast<float>(bits)));
            break;
        case RealForm::double_bits:
            for (const auto bits : take_planes<std::uint64_t>(in, count))
                numbers.push_back(std::bit_cast<double>(bits));
            break;
        default: in.fail();
    }
    return numbers;
}

void put_bools(ByteVector& out, const std::vector<bool>& values) {
    if (values.empty()) return;
    out.push_back(values[0] ? 1 : 0);
    std::uint64_t run = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i > 0 && values[i] != values[i - 1]) {
            put_varint(out, run);
            run = 0;
        }
        ++run;
    }
    put_varint(out, run);
}

std::vector<bool> take_bools(VarintReader& in, std::size_t count) {
    std::vector<bool> values;
    if (count == 0) return values;
    const Bytes first = in.take_bytes(1);
    bool value = in.good() && first[0] != 0;
    while (values.size() < count && in.good()) {
        const std::uint64_t run = in.take();
        if (run == 0 || run > count - values.size()) in.fail();
        if (in.good()) values.insert(values.end(), static_cast<std::size_t>(run), value);
        value = !value;
    }
    return values;
}

void put_texts(ByteVector& out, std::span<const std::string> texts) {
    std::map<std::string_view, std::uint64_t> numbers;
    std::vector<std::string_view> dictionary;
    std::vector<std::int64_t> indices;
    for (const auto& text : texts) {
        const auto [entry, is_new] = numbers.try_emplace(text, dictionary.size());
        if (is_new) dictionary.push_back(text);
        indices.push_back(static_cast<std::int64_t>(entry->second));
    }
    put_varint(out, dictionary.size());
    for (const auto text : dictionary) put_text(out, text);
    put_integers(out, indices);
}

std::vector<std::string> take_texts(VarintReader& in, std::size_t count) {
    std::vector<std::string> texts;
    if (const std::uint64_t distinct = in.take(); distinct > count) {
        in.fail();
    } else {
        std::vector<std::string> dictionary;
        while (dictionary.size() < distinct && in.good()) dictionary.push_back(in.take_text());
        for (const std::int64_t index : take_integers(in, count)) {
            if (index < 0 || static_cast<std::uint64_t>(index) >= dictionary.size()) in.fail();
            if (!in.good()) break;
            texts.push_back(dictionary[static_cast<std::size_t>(index)]);
        }
    }
    return texts;
}

}  // namespace takt::store
