#include "takt/wire/line_timing.hpp"

namespace takt::wire {
namespace {

constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;

// Above this rate the silences no longer shrink with the character time.
constexpr std::uint32_t kFastestByCharacters = 19200;

// bits / rate in nanoseconds, rounded up. Whole seconds apart, so that nothing overflows.
Duration time_of(std::uint64_t bits, std::uint64_t rate) {
    const std::uint64_t rest = bits % rate * kNanosecondsPerSecond;
    const std::uint64_t nanoseconds = bits / rate * kNanosecondsPerSecond + (rest + rate - 1) / rate;
    return Duration(static_cast<Duration::rep>(nanoseconds));
}

// `half_characters` halves of a character, or `fixed` above the last rate that counts in characters.
Duration silence(const CharacterFormat& format, std::uint64_t half_characters, Duration fixed) {
    if (format.baud == 0) return Duration::zero();
    if (format.baud > kFastestByCharacters) return fixed;
    return time_of(half_characters * static_cast<std::uint64_t>(format.bits()),
                   std::uint64_t{2} * format.baud);
}

}  // namespace

Duration transmission_time(const CharacterFormat& format, std::size_t characters) {
    if (format.baud == 0) return Duration::zero();
    return time_of(std::uint64_t{characters} * static_cast<std::uint64_t>(format.bits()), format.baud);
}

Duration t1_5(const CharacterFormat& format) {
    return silence(format, 3, std::chrono::microseconds(750));
}

Duration t3_5(const CharacterFormat& format) {
    return silence(format, 7, std::chrono::microseconds(1750));
}

}  // namespace takt::wire
