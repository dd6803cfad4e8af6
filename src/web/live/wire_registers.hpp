// The registers of the last responses, as they were on the wire.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "live/traffic_reader.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::web {

/// Keeps the last response to each read that it has seen. A response belongs to the request before it to the
/// same unit; with Modbus TCP framing the transaction identifiers must match as well. The owner guards it.
class WireRegisters {
public:
    static constexpr std::size_t kMostReads = 16'384;  ///< of which the responses are kept

    struct Found {
        std::vector<std::uint16_t> items;  ///< registers, or bits as 0 and 1
        std::uint8_t function = 0;
        std::uint16_t start = 0;     ///< of the request that was answered
        std::uint16_t quantity = 0;  ///< likewise
        Instant t;                   ///< of the response
    };

    /// Takes the next frame of a tap.
    void take(const TrafficFrame& frame);
    void clear();

    /// The newest response that has these items of a unit. @returns nothing: none was seen
    [[nodiscard]] std::optional<Found> find(const std::string& line, UnitId unit, wire::Area area,
                                            std::uint16_t start, std::uint16_t count) const;

private:
    /// Line, unit and transaction identifier (zero without one).
    using Exchange = std::tuple<std::string, std::uint8_t, std::uint16_t>;
    struct Asked {
        wire::Function function{};
        wire::ItemAccess access;
    };
    /// Line, unit, area.
    using Place = std::tuple<std::string, std::uint8_t, wire::Area>;
    struct Read {
        std::uint8_t function = 0;
        std::uint16_t start = 0;
        std::uint16_t quantity = 0;
        friend auto operator<=>(const Read&, const Read&) = default;
    };
    struct Answer {
        Instant t;
        std::vector<std::uint8_t> bytes;  // behind the byte count
    };

    void take_request(const Exchange& exchange, const std::vector<std::uint8_t>& pdu);
    void take_response(const Exchange& exchange, const host::TrafficRecord& record);

    std::map<Exchange, Asked> asked_;
    std::map<Place, std::map<Read, Answer>> answers_;
    std::size_t reads_ = 0;  // in answers_
};

}  // namespace takt::web
