// How long to wait before the next attempt to open a port or to connect.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "takt/base/time.hpp"

namespace takt::line {

/// 0.25 s, doubling to 5 s. With a seed each pause is up to a quarter shorter, differently for each seed, so
/// that lines that lost their links together do not reconnect together.
class Backoff {
public:
    static constexpr Duration kFirst = std::chrono::milliseconds(250);
    static constexpr Duration kLongest = std::chrono::seconds(5);

    Backoff() = default;
    /// @param name  name of the port or host, used as the seed
    explicit Backoff(std::string_view name) : jitter_(true) {
        for (const char c : name) state_ = (state_ ^ static_cast<std::uint8_t>(c)) * kPrime;
    }

    /// The pause before the next attempt. Each call doubles the following pause.
    [[nodiscard]] Duration next() {
        const Duration pause = pause_;
        pause_ = std::min(2 * pause_, kLongest);
        return jitter_ ? pause - pause * static_cast<Duration::rep>(draw() % 1024) / 4096 : pause;
    }
    /// An attempt succeeded: the next pause is the shortest one again.
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
