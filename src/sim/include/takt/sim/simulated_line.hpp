// A line of a project with its devices, all simulated, for one real master.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "takt/model/project.hpp"
#include "takt/serve/serial_slave.hpp"
#include "takt/serve/tcp_connection.hpp"
#include "takt/sim/devices.hpp"
#include "takt/sim/faults.hpp"
#include "takt/sim/wire.hpp"

namespace takt::sim {

class FaultInjector;

/// Runs a master's engine against the devices of `line` at the line's byte times: RTU and ASCII on a serial
/// bus, TCP as a stream. Bytes, values and times depend on the calls only.
///
/// In virtual time: start(), then advance() as far as wanted. In real time: the driver calls advance(now) at
/// next_wakeup() or later, and after every change of the master from outside; the engines then see the exact
/// moments at which things were due, not those of the calls, so that a late call costs no silence. One owner,
/// one thread.
class SimulatedLine {
public:
    struct Options {
        Devices::Options devices;
        /// Of the master's adapter, see SerialBus. The whole frame at once is right for every engine that
        /// keeps the contract, and fastest.
        std::size_t chunk = 0;
        bool hears_echo = false;  ///< serial: the master hears itself
        std::optional<FaultPlan> faults;
        DeviceObserver* device_observer = nullptr;  ///< may be nullptr; must outlive the line
        FaultObserver* fault_observer = nullptr;    ///< likewise
        /// Byte streams: asked after everything that happens; when true the connection is closed and made
        /// anew (a master's must_reconnect()).
        std::function<bool()> must_reconnect;
    };

    /// @param line    need not outlive it
    /// @param master  outlives it
    SimulatedLine(const model::Line& line, Engine& master) : SimulatedLine(line, master, Options{}) {}
    SimulatedLine(const model::Line& line, Engine& master, const Options& options);
    ~SimulatedLine();
    SimulatedLine(const SimulatedLine&) = delete;
    SimulatedLine& operator=(const SimulatedLine&) = delete;

    /// The link comes up, or goes down.
    void start(Instant t);
    void stop(Instant t);

    void advance(Instant t) { wire_->run_until(t); }
    [[nodiscard]] Instant next_wakeup() const { return wire_->next_wakeup(); }

    [[nodiscard]] Devices& devices() { return devices_; }
    [[nodiscard]] const serve::Counters& counters() const;
    /// What went wrong so far; all zero without a FaultPlan.
    [[nodiscard]] const FaultCounts& faults() const;

    /// The measured view: sender 0 is the master, 1 the devices, 2 noise and babble.
    void set_observer(WireObserver* observer) { wire_->set_observer(observer); }

private:
    void make_bus(const model::Line& line, Engine& master, const Options& options);
    void make_stream(const model::Line& line, Engine& master, const Options& options);

    Devices devices_;
    std::unique_ptr<serve::SerialSlave> slave_;         // of a serial line
    std::unique_ptr<serve::TcpConnection> connection_;  // of the others
    std::unique_ptr<FaultInjector> faults_;
    std::unique_ptr<Wire> wire_;
};

}  // namespace takt::sim
