// The drivers of a host's lines, and the taps between them and the engine.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/project_engine.hpp"
#include "engine/traffic_publisher.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/host/project_host.hpp"
#include "takt/line/connect_gate.hpp"
#include "takt/line/connection_limit.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::host {

/// One driver for each line of the project that runs. The I/O thread only, or while there is none.
class LineSet {
public:
    /// Called after each call of a line's engine, before the line sends.
    using OnLineEvent = std::function<void(Instant t, std::size_t line)>;

    /// @param link, loop  outlive it
    /// @param prepare     of simulated lines; may be empty
    LineSet(HostLink& link, line::Loop& loop, std::function<void(std::size_t, sim::Devices&)> prepare,
            endpoint::NoticeSink notify, OnLineEvent on_event);
    ~LineSet();
    LineSet(const LineSet&) = delete;
    LineSet& operator=(const LineSet&) = delete;

    /// The traffic observers of the lines of a project. Lines that continue() a line of the running project
    /// have its observer. They outlive the engine that uses them.
    [[nodiscard]] std::vector<std::shared_ptr<TrafficPublisher>> traffic_of(const Configuration& next) const;

    /// Opens every line for the engine. @returns what line::open_line() returns
    [[nodiscard]] Result<void> open(ProjectEngine& engine,
                                    std::vector<std::shared_ptr<TrafficPublisher>> traffic);

    /// Another engine runs: lines that continue keep their driver, the others are opened or closed. A port
    /// that cannot be opened is tried again; an event reports it.
    void move_to(ProjectEngine& engine, std::vector<std::shared_ptr<TrafficPublisher>> traffic);

    /// The line of the running project whose connection the line `index` of `next` continues to use.
    [[nodiscard]] std::optional<std::size_t> continued(const Configuration& next, std::size_t index) const;

    void poke(std::size_t line) {
        if (line < lines_.size() && lines_[line].driver) lines_[line].driver->poke();
    }

private:
    class Forwarder;
    struct Line {
        std::shared_ptr<TrafficPublisher> traffic;
        std::unique_ptr<Forwarder> forwarder;
        std::unique_ptr<sim::SimulatedLine> simulated;
        std::unique_ptr<line::Driver> driver;
    };

    [[nodiscard]] Result<void> open_line(std::size_t index, bool wait_for_port);
    void make_room(const std::string& host);

    HostLink& link_;
    line::Loop& loop_;
    std::function<void(std::size_t, sim::Devices&)> prepare_;
    endpoint::NoticeSink notify_;
    OnLineEvent on_event_;
    line::ConnectGate gate_;
    line::ConnectionLimit connection_limit_;
    ProjectEngine* engine_ = nullptr;
    std::vector<Line> lines_;
};

}  // namespace takt::host
