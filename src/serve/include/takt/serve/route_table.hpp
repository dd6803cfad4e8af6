// The routes of a server: which units are those of a line behind it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "takt/serve/answer.hpp"
#include "takt/serve/gateway.hpp"

namespace takt::serve {

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
    /// Called when the gateway has a new request, or replies. Must not take them inside the call.
    std::function<void()> on_request;
    /// Takes the transaction in flight back from the line if it was not sent yet; see
    /// Gateway::on_withdrawn(). May be empty.
    std::function<void()> withdraw{};
};

/// Where a request to a unit with a route arrives.
struct RouteTarget {
    UnitId unit;             ///< on the line
    bool broadcast = false;  ///< every unit of the line
};

/// Gives requests to units with a route to the gateway of their line. The first of several routes counts.
///
/// Each connection is a requester of its own, known by the text of its peer. One owner, one thread.
class RouteTable {
public:
    /// No routes.
    RouteTable() = default;
    /// @param server     Requester::server
    /// @param upstreams  their gateways outlive the routes
    RouteTable(std::uint32_t server, std::vector<Upstream> upstreams, const std::vector<Route>& routes);

    [[nodiscard]] bool has(UnitId unit) const { return targets_[unit.value].upstream != kNone; }

    /// Precondition: has(unit).
    [[nodiscard]] RouteTarget target(UnitId unit) const;

    /// Asks the gateway of a unit that has a route.
    /// @param token  names the request in Gateway::Reply
    /// @returns the answer where there is one at once; else the gateway will have a reply
    [[nodiscard]] std::optional<wire::Pdu> ask(const serve::Context& context,
                                               const wire::RequestView& request, serve::Token token);

    /// The client of that request is gone. A transaction that the line did not send yet is taken back.
    /// @returns as Gateway::forget()
    std::optional<Fate> forget(serve::Token token);

    /// Refuses a request that the line did not send yet. Its reply comes from the gateway.
    /// @returns false: it was sent, or no such request waits for an answer
    bool refuse(serve::Token token, wire::ExceptionCode code);

private:
    bool withdraw(const Upstream& upstream, serve::Token token) const;

    static constexpr std::size_t kNone = SIZE_MAX;
    struct Target {
        UnitId unit;
        std::size_t upstream = kNone;
    };

    std::uint32_t server_ = 0;
    std::vector<Upstream> upstreams_;
    std::array<Target, 256> targets_{};  // by unit
};

}  // namespace takt::serve
