#include "takt/wire/line_timing.hpp"

#include "takt/wire/silence.hpp"

namespace takt::wire {
namespace {

constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;

// bits / rate in nanoseconds, rounded up. Whole seconds apart, so that nothing overflows.
Duration time_of(std::uint64_t bits, std::uint64_t rate) {
    const std::uint64_t rest = bits % rate * kNanosecondsPerSecond;
    const std::uint64_t nanoseconds = bits / rate * kNanosecondsPerSecond + (rest + rate - 1) / rate;
    return Duration(static_cast<Duration::rep>(nanoseconds));
}

Duration time_of(const CharacterFormat& format, const Silence& silence) {
    if (format.baud == 0) return Duration::zero();
    if (silence.fixed > Duration::zero()) return silence.fixed;
    return time_of(silence.half_characters * static_cast<std::uint64_t>(format.bits()),
                   std::uint64_t{2} * format.baud);
}

}  // namespace

Duration transmission_time(const CharacterFormat& format, std::size_t characters) {
    if (format.baud == 0) return Duration::zero();
    return time_of(std::uint64_t{characters} * static_cast<std::uint64_t>(format.bits()), format.baud);
}

Duration t1_5(const CharacterFormat& format) {
    return time_of(format, silence_in_frame(format));
}

Duration t3_5(const CharacterFormat& format) {
    return time_of(format, silence_between_frames(format));
}

}  // namespace takt::wire
