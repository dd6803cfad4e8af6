// Events and traffic as records of a BroadcastRing. One `fields()` for each type serves both directions: the
// writer and the reader visit the same members in the same order.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "takt/host/event.hpp"
#include "takt/host/traffic.hpp"

namespace takt::host {

/// Appends the record of `event` (without its number, which the ring has) to `record`. Texts longer than
/// kLongestText are cut. Allocates only where `record` must grow.
void encode(const Event& event, std::vector<std::uint64_t>& record);
/// The same record as of a ValueChanged, without a copy of the value.
void encode(std::uint32_t generation, const value::Event& event, std::vector<std::uint64_t>& record);
[[nodiscard]] Event decode_event(std::span<const std::uint64_t> record);

/// A TrafficRecord that points to data of the caller.
struct TrafficView {
    std::uint32_t generation = 0;
    TrafficSource source;
    Instant t;
    wire::Direction direction = wire::Direction::sent;
    UnitId unit;
    std::optional<wire::FrameFault> fault = {};
    std::optional<wire::Incident> incident = {};
    Duration after{};
    std::optional<Mismatch> instead = {};
    std::string_view peer;
    Bytes pdu;
    Bytes raw;
};
void encode(const TrafficView& frame, std::vector<std::uint64_t>& record);
[[nodiscard]] TrafficRecord decode_traffic(std::span<const std::uint64_t> record);

/// A string value has at most 250 bytes; notices and audit records may be longer.
inline constexpr std::size_t kLongestText = 4096;

}  // namespace takt::host
