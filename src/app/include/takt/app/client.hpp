// One-off requests to a target: what `read`, `write` and `raw` do.
#pragma once

#include <memory>
#include <optional>

#include "takt/app/client_options.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/target.hpp"

namespace takt::app {

/// Settings of the bus for a target nothing more is known of.
[[nodiscard]] bus::LineConfig one_off_line(const line::Target& target);

/// A connection to one target with a transaction engine on it. Blocks the caller; Ctrl-C ends every wait.
class Client {
public:
    /// Opens the port or connects, within the options' time-out.
    /// @returns the target's syntax errors; cannot_open, busy, timed_out, ... with the port or host as
    /// subject
    [[nodiscard]] static Result<std::unique_ptr<Client>> open(const ClientOptions& options);

    /// Sends a request and waits for its end; repeats it up to `attempts` transmissions while nothing usable
    /// comes back. A write is repeated too: all writes the command line makes leave the device in the same
    /// state when done twice.
    /// @param repeatable  false: sent once whatever comes of it
    /// @returns a normal response or an exception, valid until the next request, empty for a broadcast;
    ///          timed_out, bad_checksum, unexpected_reply, connection_lost
    [[nodiscard]] Result<wire::ResponseView> transact(const wire::PreparedRequest& request,
                                                      bool repeatable = true);

    /// transact(); an exception is an error.
    /// @returns modbus_exception (code) besides
    [[nodiscard]] Result<wire::ResponseView> ask(const wire::Request& request);

    /// Orders something: transact(), and the response (none to a broadcast) was the confirmation.
    /// @returns modbus_exception (code) besides
    [[nodiscard]] Result<void> order(const wire::Request& request);

    /// Waits while the connection is kept, or made anew where it was lost. Returns early at Ctrl-C.
    void pause(Duration time);

    /// Requests sent so far, repetitions included.
    [[nodiscard]] std::uint64_t transmissions() const { return next_id_ - 1; }
    [[nodiscard]] bool connected() const { return driver_->up(); }

    /// Ctrl-C was pressed.
    [[nodiscard]] bool interrupted() const { return interrupted_; }

private:
    explicit Client(const ClientOptions& options) : options_(options) {}

    [[nodiscard]] Result<void> connect();
    [[nodiscard]] Result<bus::Outcome> transmit_once(const wire::PreparedRequest& request, Duration wait);
    [[nodiscard]] Duration expected_wait() const;
    void learn(const bus::Outcome& outcome);

    ClientOptions options_;
    bool interrupted_ = false;
    std::unique_ptr<TrafficLog> log_;
    std::unique_ptr<LineTraffic> traffic_;
    std::unique_ptr<line::Loop> loop_;
    std::unique_ptr<bus::TransactionEngine> engine_;
    std::unique_ptr<line::Driver> driver_;
    std::optional<Error> link_error_;
    bus::TransactionId next_id_ = 1;
    std::size_t answers_ = 0;
    Duration slowest_{};  // of them
};

}  // namespace takt::app
