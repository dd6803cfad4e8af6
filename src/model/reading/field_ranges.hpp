// Ranges of the field tables, and the contexts in which words are allowed.
#pragma once

#include <cstdint>

#include "takt/model/fields.hpp"

namespace takt::model {

using namespace std::chrono_literals;

constexpr std::int64_t in_ns(Duration duration) {
    return duration.count();
}

/// A range that does not depend on the context.
template <std::int64_t least, std::int64_t greatest>
Range between(const Context&) {
    return {least, greatest};
}

inline constexpr auto* kShortTime = between<0, in_ns(65535ms)>;
inline constexpr auto* kLongTime = between<in_ns(1ms), in_ns(24h)>;
inline constexpr auto* kDeadline = between<in_ns(1us), in_ns(24h)>;
inline constexpr auto* kBurst = between<1, 255>;
inline constexpr auto* kItem = between<0, 65535>;
inline constexpr auto* kName = between<1, 128>;
inline constexpr auto* kComment = between<0, 1000>;
inline constexpr auto* kTimeout = between<in_ns(1ms), in_ns(65535ms)>;
inline constexpr auto* kIdleClose = between<in_ns(100ms), in_ns(3600s)>;
inline constexpr auto* kPauseAfterConnect = between<0, in_ns(10s)>;
inline constexpr auto* kPath = between<1, 1000>;
inline constexpr auto* kPattern = between<1, 256>;
inline constexpr auto* kUnitId = between<0, 255>;
inline constexpr auto* kShortest = between<in_ns(10ms), in_ns(24h)>;  // least polling interval
inline constexpr auto* kCommandTime = between<in_ns(1ms), in_ns(5min)>;

std::int64_t default_timeout(const Context& context);
inline std::int64_t one_attempt(const Context&) {
    return 1;
}

Range device_name(const Context& context);
Range address(const Context& context);
Range period(const Context& context);
Range baud(const Context& context);
Range data_bits(const Context& context);
Range request_gap(const Context& context);
Range registers_per_request(const Context& context);
Range length(const Context& context);
/// Registers that a request with 0x10 carries.
std::int64_t most_written_registers(const Context& context);
bool transport_fits(std::size_t word, const Context& context);
bool framing_fits(std::size_t word, const Context& context);

}  // namespace takt::model
