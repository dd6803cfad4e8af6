// One-off requests to one device.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "takt/client/connection.hpp"
#include "takt/client/options.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::client {

/// Sends requests to one device, one at a time, and repeats those that fail by chance. Blocks its caller; a
/// stop of the connection ends every wait. A connection that the peer has closed is opened for the next
/// request. One owner, one thread.
class Client {
public:
    /// @param connection  up
    Client(std::unique_ptr<Connection> connection, const Options& options)
        : options_(options), connection_(std::move(connection)) {}

    /// Connects. Parameters and errors as connect().
    [[nodiscard]] static Result<std::unique_ptr<Client>> open(line::Loop& loop, const Options& options,
                                                              const line::TrafficFactory& traffic = {});

    /// Sends a request and waits for its end. Transmits it up to `attempts` times while no usable response
    /// comes.
    /// @param repeatable  false: it is transmitted once, because the device must not execute it twice
    /// @returns a normal response or an exception, valid until the next request, empty for a broadcast;
    ///          timed_out (ms; if the response came late, also its delay in ms and the advised time-out in
    ///          ms), bad_checksum, unexpected_reply, connection_lost; closed_by_peer; not_modbus (the bytes)
    ///          when the stream is out of step
    [[nodiscard]] Result<wire::ResponseView> transact(const wire::PreparedRequest& request,
                                                      bool repeatable = true);

    /// transact(); an exception is an error.
    /// @returns modbus_exception (code) besides
    [[nodiscard]] Result<wire::ResponseView> ask(const wire::Request& request);

    /// Orders something: ask(), and the response (none to a broadcast) is only a confirmation.
    [[nodiscard]] Result<void> order(const wire::Request& request);

    /// Keeps the connection for that time, or restores it where it was lost. Returns early after a stop.
    void pause(Duration time);

    /// Requests transmitted so far, repetitions included.
    [[nodiscard]] std::uint64_t transmissions() const { return next_id_ - 1; }
    /// Responses so far whose header has a length that is off by one. They are accepted.
    [[nodiscard]] std::uint64_t lengths_off() const { return connection_->engine().counters().lengths_off; }
    [[nodiscard]] bool connected() const { return connection_->up(); }
    /// The connection was stopped.
    [[nodiscard]] bool interrupted() const { return connection_->stopped(); }
    [[nodiscard]] Instant now() const { return connection_->now(); }

private:
    [[nodiscard]] Result<bus::Outcome> transmit_once(const wire::PreparedRequest& request, Duration wait);
    [[nodiscard]] Duration expected_wait() const;
    void learn(const bus::Outcome& outcome);
    [[nodiscard]] Error timed_out() const;
    [[nodiscard]] Error link_lost() const;
    void name_late_response(Error& error);
    [[nodiscard]] Error error_of(const bus::Outcome& outcome) const;

    Options options_;
    std::unique_ptr<Connection> connection_;
    bus::TransactionId next_id_ = 1;
    std::size_t responses_ = 0;
    Duration slowest_{};  // of them
};

}  // namespace takt::client
