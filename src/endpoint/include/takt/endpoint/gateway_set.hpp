// The gateways of a project's lines, shared by all endpoints that relay to them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "takt/endpoint/line_gateway.hpp"
#include "takt/endpoint/statistics.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/continued.hpp"
#include "takt/model/project.hpp"
#include "takt/serve/route_table.hpp"

namespace takt::endpoint {

/// One LineGateway for each line that a `relay` of a server names, with its timer. The loop's thread only.
class GatewaySet {
public:
    /// @param loop  outlives it
    /// @param deliver  as LineGateway
    GatewaySet(line::Loop& loop, LineGateway::Deliver deliver);
    ~GatewaySet();
    GatewaySet(const GatewaySet&) = delete;
    GatewaySet& operator=(const GatewaySet&) = delete;

    /// @param index  of the line in the project
    /// @param line   outlives this
    void add(std::size_t index, const model::Line& settings, SharedLine& line);

    [[nodiscard]] bool has(std::size_t index) const { return index < lines_.size() && lines_[index]; }

    /// Before another project runs: takes everything back from the lines. Their requests wait.
    void take_back();
    /// Another project runs. The gateways that are kept have their requests, answers and counters still.
    /// @param before  by index of a line in the project that runs now: its index before; nothing: no gateway
    ///                is kept for it
    void renumber(const model::Continued& before);

    /// The routes of one endpoint. Their lines were added; they must not outlive this.
    /// @param endpoint  Endpoint::id()
    [[nodiscard]] serve::RouteTable routes(std::uint32_t endpoint, const std::vector<model::Relay>& relays);

    /// Called after each call of a line's engine, before the driver sends. Other lines than those that were
    /// added do not matter.
    void after_line_event(Instant t, std::size_t index);

    [[nodiscard]] std::vector<GatewayStatistics> statistics() const;
    /// The same into what statistics() returned before, without allocating.
    void refresh(std::vector<GatewayStatistics>& statistics) const;

private:
    struct Line;

    line::Loop& loop_;
    LineGateway::Deliver deliver_;
    std::vector<std::unique_ptr<Line>> lines_;  // by index; nullptr: it is not relayed to
};

/// The units that are relayed, ascending.
[[nodiscard]] std::vector<UnitId> relayed_units(const std::vector<model::Relay>& relays);

}  // namespace takt::endpoint
