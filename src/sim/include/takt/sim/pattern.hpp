// Values that move by themselves, each in its own way, the same in every run.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/value/value.hpp"

namespace takt::sim {

/// The value of one variable as a function of time: bools toggle every few seconds, integers climb and fall
/// between 0 and 1000 (64 bits: count up), floating-point numbers swing around some value, a string is the
/// variable's name. Speed, phase and place follow from the name; nothing else goes in.
class Pattern {
public:
    Pattern(DataType type, std::string_view name);

    /// Of the alternative the type asks for (see value::Value); unscaled.
    [[nodiscard]] value::Value at(Instant t) const;

private:
    [[nodiscard]] double turns(Instant t) const;  ///< periods since the start, phase included
    [[nodiscard]] std::int64_t triangle(Instant t) const;

    DataType type_;
    std::string_view name_;
    std::uint64_t seed_;
    Duration period_;
};

/// A well mixed number that depends on the text only (FNV-1a, then the finaliser of SplitMix64).
std::uint64_t seed_of(std::string_view text);

}  // namespace takt::sim
