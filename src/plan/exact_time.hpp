// Times on one line without rounding (design, section 7).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/model/project.hpp"

namespace takt::plan {

/// A time in units of 1 ns / (2 * baud). Half a bit and a nanosecond are both whole numbers of it; 128 bits
/// hold more than a million transactions of a day each at any bit rate.
__extension__ typedef __int128 ExactTime;

/// Characters of a request and of its normal response.
struct FrameLengths {
    std::size_t request = 0;
    std::size_t response = 0;
};
[[nodiscard]] FrameLengths frame_lengths(wire::Framing framing, wire::Function function,
                                         std::size_t quantity);

/// Measures exact times on one line.
class Ruler {
public:
    explicit Ruler(const model::Line& line);

    [[nodiscard]] ExactTime of(Duration time) const { return ExactTime{time.count()} * units_per_ns_; }
    [[nodiscard]] ExactTime transaction(const model::Device& device, std::size_t request_characters,
                                        std::size_t response_characters, Duration turnaround) const;

    /// A transaction before it is stretched to request_gap, times `in_flight`; on TCP the round trip counts
    /// once for all requests in flight.
    [[nodiscard]] ExactTime occupied(const model::Device& device, std::size_t characters, Duration turnaround,
                                     std::int64_t in_flight) const;

    /// The same, in the order silence, request, turnaround, response, pause: where each ends.
    [[nodiscard]] std::array<ExactTime, 5> parts(const model::Device& device, std::size_t request_characters,
                                                 std::size_t response_characters, Duration turnaround) const;

    /// To the next whole nanosecond, at most Duration::max().
    [[nodiscard]] Duration rounded_up(ExactTime time) const;

private:
    [[nodiscard]] ExactTime half_characters(std::size_t count) const;
    [[nodiscard]] ExactTime silence() const;

    const model::Line& line_;
    std::int64_t units_per_ns_;
};

}  // namespace takt::plan
