// A line of the running project as a line of a search.
#pragma once

#include <memory>
#include <string>

#include "takt/client/port_scan.hpp"
#include "takt/host/session.hpp"

namespace takt::web {

/// The line of a search that goes through a polled line: a Modbus TCP gateway to its units. Its `port` is the
/// name of the polled line.
[[nodiscard]] model::Line bridged_line(const model::Line& polled);

struct BridgeOptions {
    Duration wait{};          ///< for a unit that is no device of the line
    bool spare = false;       ///< as of Command::Exchange
    Duration longest_wait{};  ///< for the line to have time for a request
    /// A unit without a response is answered with exception 11, as a gateway does, and the link is lost if
    /// the line had no time. Otherwise neither is answered.
    bool report_absent = true;
};

/// Opens such a line: requests go to the host as Command::Kind::exchange. The link is lost for good when the
/// project is replaced.
[[nodiscard]] client::OpenLine bridge_to(std::shared_ptr<host::Session> session, std::size_t line,
                                         const BridgeOptions& bridging);

}  // namespace takt::web
