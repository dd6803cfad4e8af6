// The routes of a server: which units are those of a line behind it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "takt/relay/gateway.hpp"
#include "takt/serve/answer.hpp"

namespace takt::relay {

/// Requests to `from` go to the unit `to` of a line.
struct Route {
    UnitId from;
    UnitId to;
    std::size_t upstream = 0;  ///< index of the line among the server's upstreams
};

/// A line that a server relays to, and how it carries the requests of this server.
struct Upstream {
    Gateway* gateway = nullptr;
    RequestPolicy policy;
    std::function<void()> on_request;  ///< called when the gateway has a new request
};

/// Gives requests to units with a route to the gateway of their line. The first of several routes counts.
///
/// Each connection is a requester of its own, known by the text of its peer. One owner, one thread.
class RelayRoutes {
public:
    /// No routes.
    RelayRoutes() = default;
    /// @param server     Requester::server
    /// @param upstreams  their gateways outlive the routes
    RelayRoutes(std::uint32_t server, std::vector<Upstream> upstreams, const std::vector<Route>& routes);

    [[nodiscard]] bool has(UnitId unit) const { return targets_[unit.value].upstream != kNone; }

    /// Asks the gateway of a unit that has a route.
    /// @param token  names the request in Gateway::Reply
    /// @returns the answer where there is one at once; else the gateway will have a reply
    [[nodiscard]] std::optional<wire::Pdu> ask(const serve::Context& context, Bytes pdu, serve::Token token);

    /// The client of that request is gone. Unknown tokens are ignored.
    void forget(serve::Token token);

private:
    static constexpr std::size_t kNone = SIZE_MAX;
    struct Target {
        UnitId unit;
        std::size_t upstream = kNone;
    };

    std::uint32_t server_ = 0;
    std::vector<Upstream> upstreams_;
    std::array<Target, 256> targets_{};  // by unit
};

}  // namespace takt::relay
