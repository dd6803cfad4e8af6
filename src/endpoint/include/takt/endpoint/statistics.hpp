// The counters of an endpoint.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/endpoint/instrument_engine.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/serve/counters.hpp"
#include "takt/serve/gateway.hpp"
#include "takt/store/register_file.hpp"

namespace takt::endpoint {

/// A TCP port or a serial port.
struct ListenerStatistics {
    std::string where;  ///< "tcp://127.0.0.1:1502", "rtu /dev/ttyUSB0 19200 bit/s"
    serve::Counters counters;
    /// The connections of a TCP port.
    struct Connections {
        line::TcpServerCounters counters;
        std::uint64_t bad_headers = 0;
        std::uint64_t frame_deadlines = 0;
        std::uint64_t idle_deadlines = 0;
    };
    std::optional<Connections> connections;
};

/// The retained registers of a unit.
struct RetainedStatistics {
    UnitId unit;
    std::string file;
    store::RegisterFile::Counters written;
};

/// The requests that were relayed to a line.
struct GatewayStatistics {
    std::size_t line = 0;  ///< index into Project::lines
    serve::GatewayCounters counters;
};

/// An instrument of the project.
struct InstrumentStatistics {
    std::string name;
    endpoint::InstrumentState state{};
    endpoint::InstrumentCounters counters;
};

/// All endpoints of a set, in their order.
struct Statistics {
    std::vector<ListenerStatistics> listeners;
    std::vector<RetainedStatistics> retained;
    std::vector<GatewayStatistics> relayed;
    std::vector<InstrumentStatistics> instruments;
};

}  // namespace takt::endpoint
