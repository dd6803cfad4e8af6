// How long to wait before the next attempt to open a port or to connect.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "takt/base/time.hpp"

namespace takt::line {

/// 0.25 s, doubling to 5 s. With a seed each pause is shorter by up to a quarter, differently for each seed:
/// those that lost their links together do not come back together.
class Backoff {
public:
    static constexpr Duration kFirst = std::chrono::milliseconds(250);
    static constexpr Duration kLongest = std::chrono::seconds(5);

    Backoff() = default;
    /// @param name  of what is to be opened: the seed
    explicit Backoff(std::string_view name) : jitter_(true) {
        for (const char c : name) state_ = (state_ ^ static_cast<std::uint8_t>(c)) * kPrime;
    }

    /// The pause before the next attempt; the one after it will be twice as long.
    [[nodiscard]] Duration next() {
        const Duration pause = pause_;
        pause_ = std::min(2 * pause_, kLongest);
        return jitter_ ? pause - pause * static_cast<Duration::rep>(draw() % 1024) / 4096 : pause;
    }
    /// The last attempt led to something: begin anew.
    void reset() { pause_ = kFirst; }

private:
    static constexpr std::uint64_t kPrime = 0x100000001B3;  // FNV-1a

    std::uint64_t draw() {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;  // Knuth, MMIX
        return state_ >> 33;
    }

    Duration pause_ = kFirst;
    std::uint64_t state_ = 0xCBF29CE484222325;
    bool jitter_ = false;
};

}  // namespace takt::line
