#include "takt/sim/pattern.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace takt::sim {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kPeak = 1000;

/// The period as a function of the seed: bools 2..9 s, the others 20..59 s.
Duration period_of(DataType type, std::uint64_t seed) {
    return type == DataType::boolean ? 1s * static_cast<int>(2 + seed % 8)
                                     : 1s * static_cast<int>(20 + seed % 40);
}

}  // namespace

std::uint64_t seed_of(std::string_view text) {
    std::uint64_t hash = 0xCBF29CE484222325;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3;
    hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9;
    hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EB;
    return hash ^ (hash >> 31);
}

Pattern::Pattern(DataType type, std::string_view name)
    : type_(type), name_(name), seed_(seed_of(name)), period_(period_of(type, seed_)) {}

value::Value Pattern::at(Instant t) const {
    switch (type_) {
        case DataType::boolean: return std::fmod(turns(t), 1.0) < 0.5;
        case DataType::int16:
        case DataType::int32: return triangle(t);
        case DataType::uint16:
        case DataType::uint32: return static_cast<std::uint64_t>(triangle(t));
        case DataType::int64: return static_cast<std::int64_t>(turns(t) * kPeak);
        case DataType::uint64: return static_cast<std::uint64_t>(turns(t) * kPeak);
        case DataType::float32:
        case DataType::float64: {
            const auto middle = static_cast<double>(10 + seed_ / 7 % 90);
            const double swing = middle / 10;
            const double exact = middle + swing * std::sin(2 * std::numbers::pi * std::fmod(turns(t), 1.0));
            return type_ == DataType::float32 ? static_cast<double>(static_cast<float>(exact)) : exact;
        }
        case DataType::string: return std::string(name_);
    }
    return {};
}

double Pattern::turns(Instant t) const {
    const double phase = static_cast<double>(seed_ >> 40) / static_cast<double>(1 << 24);
    const auto since = std::chrono::duration<double>(t.time_since_epoch());
    return std::abs(since / std::chrono::duration<double>(period_)) + phase;
}

std::int64_t Pattern::triangle(Instant t) const {
    const double turn = std::fmod(turns(t), 1.0);
    return std::llround(2 * kPeak * (turn < 0.5 ? turn : 1 - turn));
}

}  // namespace takt::sim
