// The silences of RTU lines (MODBUS over Serial Line V1.02, section 2.5.1.1), before they are rounded.
#pragma once

#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::wire {

/// The length of a silence: halves of a character, or a fixed time. One of both is zero.
struct Silence {
    std::uint64_t half_characters = 0;
    Duration fixed{};
};

/// Above this rate the silences no longer shrink with the character time.
inline constexpr std::uint32_t kFastestBySilence = 19200;

/// t1.5: 1.5 characters, 750 us above 19200 bit/s.
constexpr Silence silence_in_frame(const CharacterFormat& format) {
    if (format.baud > kFastestBySilence) return {.fixed = std::chrono::microseconds(750)};
    return {.half_characters = 3};
}

/// t3.5: 3.5 characters, 1750 us above 19200 bit/s.
constexpr Silence silence_between_frames(const CharacterFormat& format) {
    if (format.baud > kFastestBySilence) return {.fixed = std::chrono::microseconds(1750)};
    return {.half_characters = 7};
}

/// t3.5 where silences separate frames: RTU on a serial line. Else zero.
/// @param format  of a stream with bit rate 0
inline Duration frame_silence(Framing framing, const CharacterFormat& format) {
    return framing == Framing::rtu ? t3_5(format) : Duration::zero();
}

/// The least time to wait for the first byte of a response: a device responds after that silence at the
/// earliest. A shorter turnaround is the time of its program alone.
inline Duration response_wait(Framing framing, const CharacterFormat& format, Duration wait) {
    const Duration silence = frame_silence(framing, format);
    return silence > wait ? silence : wait;
}

}  // namespace takt::wire
