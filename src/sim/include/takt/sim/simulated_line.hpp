// A simulated line of a project with its devices, for one real master.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "takt/model/project.hpp"
#include "takt/serve/serial_slave.hpp"
#include "takt/serve/tcp_connection.hpp"
#include "takt/sim/devices.hpp"
#include "takt/sim/disturber.hpp"
#include "takt/sim/wire.hpp"

namespace takt::sim {

/// Runs a master's engine against the devices of `line` at the line's byte times: RTU and ASCII on a serial
/// bus, TCP as a stream. Bytes, values and times depend on the calls only.
///
/// Clocks. Virtual time: call start(), then advance() as far as wanted. Real time: the driver calls
/// advance(now) at next_wakeup() or later, and after every change of the master from outside. In both cases
/// the engines get the exact instants of the events, not those of the calls, so a late call shortens no
/// silence. One owner, one thread.
class SimulatedLine {
public:
    struct Options {
        Devices::Options devices;
        /// Chunk size of the master's adapter, see SerialBus. Whole frames are the fastest, and correct for
        /// every engine that keeps the contract.
        std::size_t chunk = 0;
        bool receives_echo = false;  ///< serial: the master receives its own transmissions
        /// Makes the faults of the line; empty: there are none.
        std::function<std::unique_ptr<LineFaults>(const model::Line& line, Devices& devices)> faults;
        DeviceObserver* device_observer = nullptr;  ///< may be nullptr; must outlive the line
        /// Byte streams: returns true to close and reopen the connection (a master's must_reconnect()).
        /// Called after every event.
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
    /// What Options::faults made; nullptr: nothing.
    [[nodiscard]] const LineFaults* faults() const { return faults_.get(); }

    /// The measured view: sender 0 is the master, 1 the devices, 2 noise and babble.
    void set_observer(WireObserver* observer) { wire_->set_observer(observer); }

private:
    void make_bus(const model::Line& line, Engine& master, serve::Responder& responder,
                  const Options& options);
    void make_stream(const model::Line& line, Engine& master, serve::Responder& responder,
                     const Options& options);

    Devices devices_;
    std::unique_ptr<serve::SerialSlave> slave_;         // of a serial line
    std::unique_ptr<serve::TcpConnection> connection_;  // of the others
    std::unique_ptr<LineFaults> faults_;
    std::unique_ptr<Wire> wire_;
};

}  // namespace takt::sim
