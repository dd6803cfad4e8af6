// Decimal scaling: scale and offset are brought to a common power of ten, so that
//
//     value = (raw * numerator + shift) / denominator
//
// As long as all intermediate integers stay below 2^53, only the division rounds. The result is then the
// double nearest to the decimal value. Beyond that limit plain double arithmetic is used.
#include "scaling.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace takt::value {
namespace {

constexpr double kExact = 9007199254740992.0;  // 2^53: integers up to this value are exact in a double

/// The least power of ten that makes `number` an integer; nothing if there is no short one.
std::optional<double> decimal_denominator(double number) {
    double power = 1;
    for (int digits = 0; digits <= 15; ++digits, power *= 10) {
        const double whole = std::round(number * power);
        if (std::abs(whole) <= kExact && whole / power == number) return power;
    }
    return std::nullopt;
}

}  // namespace

Scaling::Scaling(double scale, double offset) : scale_(scale), offset_(offset) {
    const auto a = decimal_denominator(scale);
    const auto b = decimal_denominator(offset);
    if (!a || !b) return;
    denominator_ = std::max(*a, *b);
    numerator_ = std::round(scale * *a) * (denominator_ / *a);
    shift_ = std::round(offset * *b) * (denominator_ / *b);
    if (std::abs(numerator_) > kExact || std::abs(shift_) > kExact) denominator_ = 0;
}

double Scaling::value(double raw) const {
    const double product = raw * numerator_;
    const double sum = product + shift_;
    const bool whole = raw == std::round(raw) && std::abs(raw) <= kExact;
    if (denominator_ != 0 && whole && std::abs(product) <= kExact && std::abs(sum) <= kExact)
        return sum / denominator_;
    return raw * scale_ + offset_;
}

double Scaling::inverse(double value) const {
    const double scaled = value * denominator_;
    if (denominator_ != 0 && std::abs(scaled) <= kExact) return (scaled - shift_) / numerator_;
    return (value - offset_) / scale_;
}

double Scaling::whole_inverse(double value) const {
    const double nearest = std::round(inverse(value));
    for (const double candidate : {nearest, nearest - 1, nearest + 1})
        if (this->value(candidate) == value) return candidate;
    return nearest;
}

}  // namespace takt::value
