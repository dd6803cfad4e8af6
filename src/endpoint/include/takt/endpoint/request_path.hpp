// Where a request of an endpoint goes.
#pragma once

#include <optional>

#include "takt/serve/answer.hpp"
#include "takt/serve/route_table.hpp"

namespace takt::endpoint {

/// The path of one request. Access rules, routing and audit use the same one, so they cannot differ.
struct RequestPath {
    bool own = false;                          ///< own units: all of them for a broadcast
    std::optional<serve::RouteTarget> target;  ///< on a line
    std::optional<serve::Token> relayed;       ///< the line has the request; its reply has this token
    std::optional<wire::Pdu> rejection;        ///< the gateway's answer at once, or from its cache
};

}  // namespace takt::endpoint
