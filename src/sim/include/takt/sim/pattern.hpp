// Patterns of moving values, the same in every run.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/value/value.hpp"

namespace takt::sim {

/// The value of one variable as a function of time. Bools toggle every few seconds; integers rise and fall
/// between 0 and 1000 (64-bit ones count up); floating-point numbers oscillate around a mean; a string is the
/// variable's name. Speed, phase and mean depend only on the name.
class Pattern {
public:
    Pattern(DataType type, std::string_view name);

    /// The alternative that the type requires (see value::Value); unscaled.
    [[nodiscard]] value::Value at(Instant t) const;

private:
    [[nodiscard]] double turns(Instant t) const;  ///< periods since the start, phase included
    [[nodiscard]] std::int64_t triangle(Instant t) const;

    DataType type_;
    std::string_view name_;
    std::uint64_t seed_;
    Duration period_;
};

/// A hash of the text (FNV-1a, then the finaliser of SplitMix64).
std::uint64_t seed_of(std::string_view text);

}  // namespace takt::sim
