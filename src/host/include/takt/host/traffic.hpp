// The frames on a host's lines and endpoints, as traffic taps get them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/framer.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::host {

/// Where a frame was seen.
struct TrafficSource {
    enum class Kind : std::uint8_t { line, endpoint };
    Kind kind = Kind::line;
    std::size_t index = 0;  ///< of the line in the project, or of the endpoint
    friend bool operator==(const TrafficSource&, const TrafficSource&) = default;
};

/// A frame, bytes that were dropped, or an incident.
struct TrafficRecord {
    std::uint32_t generation = 0;
    TrafficSource source;
    Instant t;
    wire::Direction direction = wire::Direction::sent;
    UnitId unit;
    std::optional<wire::FrameFault> fault;   ///< why bytes were dropped; then there is no frame
    std::optional<wire::Incident> incident;  ///< then there is no frame
    Duration after{};                        ///< of the incident
    std::optional<Mismatch> instead;         ///< likewise
    std::string peer;                        ///< of an endpoint's connection: "192.0.2.7:50100"; else empty
    std::vector<std::uint8_t> pdu;
    std::vector<std::uint8_t> raw;  ///< as on the wire; of dropped bytes those that were kept
};

}  // namespace takt::host
