// Where a request of an endpoint goes.
#pragma once

#include <optional>

#include "takt/relay/route_table.hpp"
#include "takt/serve/answer.hpp"

namespace takt::endpoint {

/// The path of one request. Access rules, routing and audit use the same one, so they cannot differ.
struct RequestPath {
    bool own = false;                          ///< own units: all of them for a broadcast
    std::optional<relay::RouteTarget> target;  ///< on a line
    std::optional<serve::Token> relayed;       ///< the line has the request; its reply has this token
    std::optional<wire::Pdu> rejection;        ///< the gateway's answer at once, or from its cache
};

}  // namespace takt::endpoint
