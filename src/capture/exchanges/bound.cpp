// The Clopper-Pearson bound p solves I_p(events + 1, trials - events) = confidence, where I is the
// regularised incomplete beta function: here by its continued fraction (Lentz; Numerical Recipes,
// section 6.4) and bisection.
#include "takt/capture/bound.hpp"

#include <cmath>

namespace takt::capture {
namespace {

constexpr std::uint64_t kLeastForRuleOfThree = 30;

double continued_fraction(double a, double b, double x) {
    constexpr int kMostTerms = 100'000;
    constexpr double kPrecision = 1e-12;
    constexpr double kTiny = 1e-300;
    const auto away_from_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
    double c = 1;
    double d = 1 / away_from_zero(1 - (a + b) * x / (a + 1));
    double result = d;
    for (int i = 1; i <= kMostTerms; ++i) {
        const double m = i;
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / away_from_zero(1 + even * d);
        c = away_from_zero(1 + even / c);
        result *= d * c;
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / away_from_zero(1 + odd * d);
        c = away_from_zero(1 + odd / c);
        result *= d * c;
        if (std::abs(d * c - 1) < kPrecision) break;
    }
    return result;
}

/// std::lgamma() writes a global variable; arguments here are positive, its sign is not needed.
double log_gamma(double x) {
    int sign = 0;
    return ::lgamma_r(x, &sign);
}

double incomplete_beta(double a, double b, double x) {
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    const double front =
        std::exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * std::log(x) + b * std::log1p(-x));
    if (x < (a + 1) / (a + b + 2)) return front * continued_fraction(a, b, x) / a;
    return 1 - front * continued_fraction(b, a, 1 - x) / b;
}

}  // namespace

double upper_bound(std::uint64_t events, std::uint64_t trials) {
    if (events >= trials) return 1;
    if (events == 0 && trials >= kLeastForRuleOfThree) return 3 / static_cast<double>(trials);
    const double a = static_cast<double>(events) + 1;
    const double b = static_cast<double>(trials - events);
    double low = 0;
    double high = 1;
    for (int i = 0; i < 200 && high - low > high * 1e-12; ++i) {
        const double middle = (low + high) / 2;
        (incomplete_beta(a, b, middle) < kConfidence ? low : high) = middle;
    }
    return high;
}

std::uint64_t one_in(double probability) {
    constexpr double kRounding = 1e-12;  // 1 / (3.0 / 3e9) is a little less than 1e9
    const double exact = (1 + kRounding) / probability;
    if (exact < 1) return 1;
    const auto whole = static_cast<std::uint64_t>(exact);
    std::uint64_t unit = 1;
    while (whole / unit >= 100) unit *= 10;
    return whole / unit * unit;
}

}  // namespace takt::capture
