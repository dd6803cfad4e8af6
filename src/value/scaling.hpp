// Scale and offset as decimal fractions, without the errors of binary ones.
#pragma once

namespace takt::value {

/// value = raw * scale + offset.
///
/// If scale and offset are short decimal fractions and the numbers are small enough, the value is one
/// correctly rounded division of integers: raw 12 with scale 0.1 is 12 / 10, the double of "1.2". Otherwise
/// plain double arithmetic.
class Scaling {
public:
    Scaling(double scale, double offset);

    [[nodiscard]] double value(double raw) const;

    /// The real number that value() would map to `value`, up to rounding errors.
    [[nodiscard]] double inverse(double value) const;

    /// The raw integer for `value`: one that gives exactly `value` if it exists, else the nearest.
    [[nodiscard]] double whole_inverse(double value) const;

private:
    double scale_;
    double offset_;
    double denominator_ = 0;  // 10^n, 0: not decimal
    double numerator_ = 0;    // scale * 10^n, a whole number
    double shift_ = 0;        // offset * 10^n, a whole number
};

}  // namespace takt::value
