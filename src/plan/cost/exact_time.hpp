// Times on one line without rounding (docs/planning.md, "Bus time").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/inplace_vector.hpp"
#include "takt/base/time.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// A time in units of 1 ns / (2 * baud), so that half a bit and a nanosecond are both integers. 128 bits hold
/// more than a million transactions of a day each at any bit rate.
__extension__ typedef __int128 ExactTime;

/// Characters of a request and of its normal response.
struct FrameLengths {
    std::size_t request = 0;
    std::size_t response = 0;
};
/// @param written  registers written by 0x17, whose `quantity` is read
[[nodiscard]] FrameLengths frame_lengths(wire::Framing framing, wire::Function function, std::size_t quantity,
                                         std::size_t written = 0);

/// The transactions of one read or one write of a request, sent back to back: two for a read-modify-write,
/// else one; none if the request does not read (write). The transaction of 0x17 is both its read and its
/// write.
using Transactions = InplaceVector<FrameLengths, 2>;
[[nodiscard]] Transactions read_transactions(wire::Framing framing, const Request& request);
[[nodiscard]] Transactions write_transactions(wire::Framing framing, const Request& request);
/// The transactions of the read; for a write-only request, those of the write.
[[nodiscard]] Transactions main_transactions(wire::Framing framing, const Request& request);

/// Exact times on one line.
class BusTimeModel {
public:
    explicit BusTimeModel(const model::Line& line);

    [[nodiscard]] ExactTime of(Duration time) const { return ExactTime{time.count()} * units_per_ns_; }
    [[nodiscard]] ExactTime transaction(const model::Device& device, std::size_t request_characters,
                                        std::size_t response_characters, Duration turnaround) const;
    /// The sum of consecutive transactions.
    [[nodiscard]] ExactTime sum(const model::Device& device, const Transactions& transactions,
                                Duration turnaround) const;

    /// The cost of opening a connection for a request; 0 on a line that keeps its connection.
    /// @param way_and_back  the time to the device and back
    [[nodiscard]] ExactTime connecting(Duration way_and_back) const;

    /// `in_flight` times the duration of a transaction before request_gap stretches it. On TCP the round trip
    /// counts once for all requests in flight.
    [[nodiscard]] ExactTime occupied(const model::Device& device, std::size_t characters, Duration turnaround,
                                     std::int64_t in_flight) const;

    /// The ends of the parts of a transaction: silence, request, turnaround, response, pause.
    [[nodiscard]] std::array<ExactTime, 5> parts(const model::Device& device, std::size_t request_characters,
                                                 std::size_t response_characters, Duration turnaround) const;

    /// Rounded up to nanoseconds, at most Duration::max().
    [[nodiscard]] Duration rounded_up(ExactTime time) const;
    [[nodiscard]] std::int64_t microseconds_up(ExactTime time) const;

    /// The duration of consecutive characters.
    [[nodiscard]] ExactTime characters(std::size_t count) const;
    /// t3.5 on RTU lines, else zero.
    [[nodiscard]] ExactTime silence() const;

private:
    [[nodiscard]] ExactTime half_characters(std::size_t count) const;

    const model::Line& line_;
    std::int64_t units_per_ns_;
};

}  // namespace takt::plan
