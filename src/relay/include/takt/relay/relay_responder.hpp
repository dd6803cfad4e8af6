// The responder of a server that passes requests on to lines.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "takt/relay/gateway.hpp"
#include "takt/serve/answer.hpp"

namespace takt::relay {

/// Requests to `from` go to the unit `to` of a line.
struct Route {
    UnitId from;
    UnitId to;
    std::size_t way = 0;  ///< RelayResponder::Way
};

/// The server's own units answer as they do; requests to units with a route go to that line's gateway, all
/// others are exception 0x0A. An own unit goes before a route, the first of several routes counts. Over TCP
/// the units 0 and 255 mean the server itself where they have no route; on a serial line a broadcast goes to
/// the own units, and on along the route of unit 0.
///
/// Each connection is a client of its own. Answers that take their time are pending. One owner, one thread.
class RelayResponder final : public serve::Responder {
public:
    /// A line, and how it treats this server's requests.
    struct Way {
        Gateway* gateway = nullptr;
        Treatment treatment;
        std::function<void()> asked;  ///< called when the gateway has a new request
    };

    /// @param server  Asker::server
    /// @param own     its own units; nullptr: it has none. Outlives it, and so do the gateways
    /// @param tokens  those of the server; outlives it
    RelayResponder(std::uint32_t server, serve::Responder* own, serve::Tokens& tokens, std::vector<Way> ways,
                   const std::vector<Route>& routes);

    [[nodiscard]] bool serves(UnitId unit) const override;
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override;
    void heard(serve::LineEvent event) override;
    void forget(serve::Token token) override;

private:
    struct Target {
        UnitId unit;
        const Way* way = nullptr;
    };

    serve::Answer pass_on(const serve::Context& context, const Target& target, Bytes pdu);

    std::uint32_t server_;
    serve::Responder* own_;
    serve::Tokens& tokens_;
    std::vector<Way> ways_;
    std::array<Target, 256> targets_{};  // by unit; without a way: none
};

}  // namespace takt::relay
