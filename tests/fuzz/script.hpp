// Scripts for engines: the input lists received bytes and pauses, step by step.
#pragma once

#include <algorithm>
#include <cstdint>

#include "input.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::fuzz {

inline wire::CharacterFormat format_of(std::uint8_t choice) {
    return {(choice & 1) != 0 ? 115200U : 9600U, 8, wire::Parity::even, 1};
}

/// One of the existing units, or a neighbour.
inline UnitId unit_of(std::uint8_t what) {
    return UnitId{static_cast<std::uint8_t>(what / 8 % 4)};
}

inline Bytes take_noise(Input& input) {
    return input.bytes(input.byte() % 64 + 1U);
}

/// Empty at the end of the input.
inline Bytes take_pdu(Input& input) {
    return input.bytes(std::min<std::size_t>(input.byte() + 1U, wire::kMaxPdu));
}

/// Advances time like a punctual driver. `step` is called at each wake-up.
template <class Step>
void run_until(const Engine& engine, Instant& now, Instant end, Step step) {
    constexpr int kMostWakeups = 10'000;
    for (int wakeups = 0; engine.next_wakeup() <= end; ++wakeups) {
        require(wakeups < kMostWakeups);
        now = std::max(now, engine.next_wakeup());
        step(now);
    }
    now = std::max(now, end);
}

}  // namespace takt::fuzz
