// Engines put to work on real lines: serial ports and TCP connections that come back by themselves.
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

namespace takt::sim {
class SimulatedLine;
}

namespace takt::line {

class ConnectGate;

/// Told when the link comes up (`why` empty) and when it goes down or an attempt to get it fails (why:
/// cannot_open, busy, timed_out, connection_lost, io_failed with the port or host as subject). Called right
/// before the engine is told that the link is up, and right after it was told that it is down. On the
/// loop's thread, never from within the call that makes the driver; may stop the loop, but not destroy the
/// driver.
using LinkListener = std::function<void(Instant t, bool up, const std::optional<Error>& why)>;

struct DriverOptions {
    LinkListener on_link;
    /// The engine's stream is out of step: the line is closed and opened anew. Asked after every call of
    /// the engine (a master's must_reconnect()).
    std::function<bool()> must_reconnect;
    /// Serial: a port that cannot be opened at first is tried again and again instead of being an error.
    bool wait_for_port = false;
    /// TCP: longest time for one address of the host to accept the connection.
    Duration connect_limit = std::chrono::seconds(3);
    /// TCP: what attempts to connect wait for; must outlive the driver. nullptr: they wait for nothing.
    ConnectGate* gate = nullptr;
};

/// Of real lines; a simulated one counts its links only.
struct DriverCounters {
    std::uint64_t bytes_read = 0;
    std::uint64_t bytes_written = 0;
    std::uint64_t links = 0;            ///< how often the link came up
    std::uint64_t failed_attempts = 0;  ///< to open the port or to connect
    SerialCounters serial;
};

/// One engine at work on one line. A lost link is looked for again after 0.25 s, then in steps that double
/// up to 5 s (TCP: up to a quarter less, by a seed of its name); the engine is told of both by on_link().
/// Destroying the driver closes the line at once, without telling the engine. The loop and the engine must
/// outlive it. The loop's thread only.
class Driver {
public:
    virtual ~Driver() = default;

    /// To be called after the engine was changed from outside (a command was queued): takes its bytes and
    /// its wake-up.
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

/// A master on a TCP connection (Modbus TCP, or RTU over TCP: that is the engine's business). Connects in
/// the background: what comes of it tells options.on_link. Names are resolved on a thread of their own;
/// every address of a host is tried.
[[nodiscard]] std::unique_ptr<Driver> connect_tcp(Loop& loop, const std::string& host, std::uint16_t port,
                                                  Engine& engine, const DriverOptions& options = {});

/// A simulated line in real time, at its real byte times; `line` must outlive the driver.
[[nodiscard]] std::unique_ptr<Driver> run_simulated(Loop& loop, sim::SimulatedLine& line, std::string name,
                                                    const DriverOptions& options = {});

/// The line of a project with its master: serial, tcp or simulated (with its devices as the project
/// describes them). @returns unsupported ("tls"), else as above
[[nodiscard]] Result<std::unique_ptr<Driver>> open_line(Loop& loop, const model::Line& line, Engine& engine,
                                                        const DriverOptions& options = {});

[[nodiscard]] inline Result<std::unique_ptr<Driver>> open_target(Loop& loop, const Target& target,
                                                                 Engine& engine,
                                                                 const DriverOptions& options = {}) {
    return open_line(loop, target.as_line(), engine, options);
}

}  // namespace takt::line
