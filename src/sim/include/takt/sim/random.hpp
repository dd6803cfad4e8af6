// Random numbers that are the same on every machine.
#pragma once

#include <cstdint>

#include "takt/base/assert.hpp"
#include "takt/base/time.hpp"

namespace takt::sim {

/// A stream of numbers that depends on its seed alone (SplitMix64: Steele, Lea, Flood 2014). The
/// distributions of the standard library differ between implementations and are not used. A copy continues at
/// the same number.
class Random {
public:
    explicit constexpr Random(std::uint64_t seed) : state_(seed) {}

    constexpr std::uint64_t next() {
        state_ += 0x9E3779B97F4A7C15;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
        return z ^ (z >> 31);
    }

    /// 0..limit-1; limit > 0. The bias is below limit / 2^32.
    constexpr std::uint32_t below(std::uint32_t limit) {
        TAKT_ASSERT(limit > 0);
        return static_cast<std::uint32_t>(((next() >> 32) * limit) >> 32);
    }

    constexpr bool chance(std::uint32_t per_million) { return below(1'000'000) < per_million; }

    /// least..most, inclusive; most >= least.
    constexpr Duration between(Duration least, Duration most) {
        return least + Duration(static_cast<Duration::rep>(fraction() *
                                                           static_cast<double>((most - least).count() + 1)));
    }

    /// 0 <= x < 1, in steps of 2^-53.
    constexpr double fraction() { return static_cast<double>(next() >> 11) * 0x1p-53; }

    /// An independent stream for another purpose, so that further draws there change nothing here.
    constexpr Random fork(std::uint64_t purpose) { return Random(next() ^ (purpose * 0xD1342543DE82EF95)); }

private:
    std::uint64_t state_;
};

}  // namespace takt::sim
