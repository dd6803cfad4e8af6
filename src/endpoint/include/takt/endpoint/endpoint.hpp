// One server on real bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "takt/endpoint/environment.hpp"
#include "takt/endpoint/feed.hpp"
#include "takt/endpoint/request_handler.hpp"
#include "takt/endpoint/spec.hpp"
#include "takt/endpoint/statistics.hpp"

namespace takt::sim {
class Devices;
}

namespace takt::endpoint {

class Listener;
class RetainedUnit;

/// An EndpointSpec at work: units, rules, audit, retained registers, bindings and listeners around one
/// RequestHandler. Made in steps: the constructor opens nothing, so that handler() can be asked without a
/// file or a port; then connect(), open_retained(), listen(). The loop's thread only.
class Endpoint {
public:
    /// @param id  unique among the endpoints of a set, as long as it lives
    Endpoint(std::uint32_t id, EndpointSpec spec, const Environment& environment);
    ~Endpoint();
    Endpoint(const Endpoint&) = delete;
    Endpoint& operator=(const Endpoint&) = delete;

    [[nodiscard]] std::uint32_t id() const { return id_; }
    [[nodiscard]] const EndpointSpec& spec() const { return spec_; }
    [[nodiscard]] RequestHandler& handler() { return *handler_; }
    /// The devices of LineDevices, in their order; nullptr: the units are others.
    [[nodiscard]] sim::Devices* devices();

    /// Connects bound variables with their sources; before that, reads of them are exception 0x0B.
    /// @returns as endpoint::Bindings::connect()
    [[nodiscard]] Result<void> connect(endpoint::Feeds& feeds, endpoint::ProjectValues& values);
    void disconnect();
    /// Another project runs in which this endpoint continues (model::continued_servers()): takes its access
    /// rules and the numbers of its lines.
    /// @param spec  of this endpoint in that project
    void enter(const EndpointSpec& spec);
    /// Connects with the values of that project. @returns as endpoint::Bindings::reconnect()
    [[nodiscard]] Result<void> reconnect(endpoint::Feeds& feeds, endpoint::ProjectValues& values);
    /// Opens the files of retained registers. @returns as RetainedUnit::open()
    [[nodiscard]] Result<void> open_retained();
    /// Begins to answer, and reports where ("endpoint.serving").
    /// @returns what opening an address or a serial port returns
    [[nodiscard]] Result<void> listen();

    /// Appends what was counted so far.
    void add_statistics(Statistics& statistics) const;
    /// The same into what add_statistics() appended before, without allocating. Takes its part off both
    /// spans.
    void refresh(std::span<ListenerStatistics>& listeners, std::span<RetainedStatistics>& retained) const;

    /// Writes what is left of the retained registers, and answers all writes that wait for them.
    void finish_retained(Statistics& statistics);
    /// Closes the listeners, so that their connections are counted too.
    void close(Statistics& statistics);

private:
    struct OwnUnits;

    void add_hooks();

    const std::uint32_t id_;
    EndpointSpec spec_;
    const Environment& environment_;
    std::unique_ptr<OwnUnits> own_;
    std::unique_ptr<RequestHandler> handler_;
    std::unique_ptr<endpoint::Bindings> bindings_;  // nullptr: nothing is bound
    std::vector<std::unique_ptr<RetainedUnit>> retained_;
    std::vector<std::unique_ptr<Listener>> listeners_;
};

/// "1, 2, 5..20": units, ascending; longer runs as ranges.
[[nodiscard]] std::string units_text(std::vector<UnitId> units);

}  // namespace takt::endpoint
