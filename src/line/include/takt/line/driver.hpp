// Drivers run engines on real lines: serial ports and TCP connections, which are reopened after a failure.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/serial_port.hpp"
#include "takt/line/target.hpp"
#include "takt/model/project.hpp"
#include "takt/tls/context.hpp"

namespace takt::sim {
class SimulatedLine;
}

namespace takt::line {

class ConnectGate;
class ConnectionLimit;

/// Called when the link comes up (`why` is empty), goes down, or an attempt fails. `why`: cannot_open, busy,
/// timed_out, connection_lost, io_failed or (TCP) not_modbus, tls_failed, with the port or host as subject.
/// Order: right before the engine's on_link(up), right after its on_link(down). Called on the loop's thread,
/// never from the driver's constructor. It may stop the loop but not destroy the driver.
using LinkListener = std::function<void(Instant t, bool up, const std::optional<Error>& why)>;

struct DriverOptions {
    LinkListener on_link;
    /// TCP, an engine with opens_at(): called instead of on_link when a connection was closed that the engine
    /// will open again. `why` is empty if the engine asked for it. Nothing is called when it is open again.
    std::function<void(Instant t, const std::optional<Error>& why)> on_close;
    /// Returns true if the engine's stream is out of step; the line is then closed and reopened. Called after
    /// every call of the engine (a master's must_reconnect()).
    std::function<bool()> must_reconnect;
    /// Serial: called with SerialPort::latency() when the port is open, before on_link, and again if a
    /// reopened port has another one. May be empty.
    std::function<void(const SerialLatency&)> on_latency;
    /// Serial: a port that cannot be opened at first is retried and is no error.
    bool wait_for_port = false;
    /// TCP: time limit of connect() for one address of the host.
    Duration connect_limit = std::chrono::seconds(3);
    /// TCP: limits the attempts to connect; must outlive the driver. nullptr: no limit.
    ConnectGate* gate = nullptr;
    /// TCP: the limit of connections to its host, and how many there may be; nullptr: without limit.
    ConnectionLimit* connection_limit = nullptr;
    std::size_t connections_per_host = 1;
    /// TCP: the connection is TLS with it; nullptr: plain. The handshake has a time of its own,
    /// `connect_limit` again.
    std::shared_ptr<const tls::Context> tls = nullptr;
    /// TCP: SocketStream::acknowledge_at_once().
    bool acknowledge_at_once = false;
};

/// Counters of a driver. A simulated line counts only its links.
struct DriverCounters {
    std::uint64_t bytes_read = 0;
    std::uint64_t bytes_written = 0;
    std::uint64_t links = 0;            ///< how often the link came up
    std::uint64_t failed_attempts = 0;  ///< to open the port or to connect
    SerialCounters serial;
};

/// Runs one engine on one line. After a lost link it retries after 0.25 s, then in steps that double up to 5
/// s (TCP: up to a quarter less, by a seed of its name). The engine learns of both by on_link(). A closed
/// connection is made again when Engine::opens_at() says so. Destroying
/// the driver closes the line without a call of the engine. The loop and the engine must outlive it. The
/// loop's thread only.
class Driver {
public:
    virtual ~Driver() = default;

    /// Must be called after the engine was changed from outside (a command was queued): fetches its bytes and
    /// its next wake-up.
    virtual void poke() = 0;
    [[nodiscard]] virtual bool up() const = 0;
    /// "/dev/ttyUSB0", "host:502".
    [[nodiscard]] virtual const std::string& name() const = 0;
    [[nodiscard]] virtual DriverCounters counters() const = 0;
};

/// A master or a slave on a serial port.
/// @returns the errors of SerialPort::open(); with `wait_for_port` only `unsupported` and `out_of_range`
[[nodiscard]] Result<std::unique_ptr<Driver>> open_serial(Loop& loop, const SerialSettings& settings,
                                                          Engine& engine, const DriverOptions& options = {});

/// A master on a TCP connection (Modbus TCP, or RTU over TCP: the engine decides). Connects in the background
/// and reports the result to options.on_link. Names are resolved on a thread of their own; all addresses of a
/// host are tried in order.
[[nodiscard]] std::unique_ptr<Driver> connect_tcp(Loop& loop, const std::string& host, std::uint16_t port,
                                                  Engine& engine, const DriverOptions& options = {});

/// A simulated line in real time, at its real byte times; `line` must outlive the driver.
[[nodiscard]] std::unique_ptr<Driver> run_simulated(Loop& loop, sim::SimulatedLine& line, std::string name,
                                                    const DriverOptions& options = {});

/// The line of a project with its master: serial, tcp or simulated (with its devices as the project
/// describes them). @returns as above; of TLS the errors of tls::Context::load()
[[nodiscard]] Result<std::unique_ptr<Driver>> open_line(Loop& loop, const model::Line& line, Engine& engine,
                                                        const DriverOptions& options = {});

}  // namespace takt::line
