// What each endpoint of a server served and refused: the summary at the end of `takt serve`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/report/texts.hpp"
#include "takt/serve/counters.hpp"

namespace takt::report {

/// The connections of an endpoint that listens on a TCP port.
struct ConnectionCounts {
    std::uint64_t accepted = 0;
    std::uint64_t refused = 0;          ///< for any reason
    std::uint64_t over_limit = 0;       ///< refused: the endpoint has its most connections
    std::uint64_t over_peer_limit = 0;  ///< refused: the peer has its most connections
    std::uint64_t no_descriptors = 0;   ///< refused: no file descriptor was left
    std::uint64_t evicted = 0;          ///< ended: idle, while there was no room for a new one
    std::uint64_t bad_headers = 0;      ///< ended: the MBAP header was wrong
    std::uint64_t frame_deadlines = 0;  ///< ended: a frame was not complete in time
    std::uint64_t idle_deadlines = 0;   ///< ended: no request came
    std::uint64_t write_stalls = 0;     ///< ended: the client did not read its responses
};

struct EndpointSummary {
    std::string where;  ///< "tcp://127.0.0.1:1502", "rtu /dev/ttyUSB0 19200 bit/s"
    serve::Counters counters;
    std::optional<ConnectionCounts> connections;  ///< nothing for a serial line
};

/// What was written of the retained registers of a unit.
struct RetainedSummary {
    UnitId unit;
    std::string file;
    std::uint64_t commits = 0;
    std::uint64_t bytes = 0;
    std::uint64_t failures = 0;
};

struct ServeSummary {
    std::vector<EndpointSummary> endpoints;
    std::vector<RetainedSummary> retained;
};

/// One line for each endpoint, a second one for its connections, one each for refused and ended connections
/// where there are any, and one for each unit with retained registers.
[[nodiscard]] std::string served_text(const Texts& texts, const ServeSummary& summary);

/// The summary as one JSON object and a line end.
/// @param event  value of the key `event`, which comes first in a stream of events; empty: no such key
[[nodiscard]] std::string served_json(const ServeSummary& summary, std::string_view event = {});

}  // namespace takt::report
