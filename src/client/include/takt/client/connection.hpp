// The connection of a client: an engine on a line, and a way to let time pass.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/client/options.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/traffic_factory.hpp"

namespace takt::client {

/// Runs a transaction engine on one line. One owner, one thread.
class Connection {
public:
    virtual ~Connection() = default;

    [[nodiscard]] virtual bus::TransactionCore& engine() = 0;
    /// Must be called after the engine was given a request.
    virtual void poke() = 0;
    [[nodiscard]] virtual bool up() const = 0;
    /// Opens a connection that the peer has closed. Waits for it, at most `limit`. @returns up()
    virtual bool reopen(Duration /*limit*/) { return up(); }
    /// Why there is no link; nothing: there is one, or the reason is unknown.
    [[nodiscard]] virtual std::optional<Error> link_error() const { return std::nullopt; }
    [[nodiscard]] virtual Instant now() const = 0;
    /// Moves bytes until `done()` is true, the connection is stopped, or `limit` has passed.
    virtual void run_until(const std::function<bool()>& done, Duration limit) = 0;
    /// The user has ended the work: no more waiting.
    [[nodiscard]] virtual bool stopped() const = 0;
};

/// The bus settings of a line whose devices are unknown.
[[nodiscard]] bus::LineConfig one_off_line(const model::Line& line);

/// Opens a line as line::open_line() does.
using OpenLine = std::function<Result<std::unique_ptr<line::Driver>>(
    line::Loop& loop, const model::Line& line, Engine& engine, const line::DriverOptions& options)>;

/// Opens the port of a target, or connects to its host, within the time-out.
/// @param loop     outlives the connection, which is stopped when the loop is
/// @param traffic  makes the observer of the frames; may be empty
/// @returns the target's syntax errors; cannot_open, busy, timed_out, … with the port or host as subject
[[nodiscard]] Result<std::unique_ptr<Connection>> connect(line::Loop& loop, const Options& options,
                                                          const line::TrafficFactory& traffic = {});

/// The same for a line, which `open` opens. `options.target` names it in errors.
[[nodiscard]] Result<std::unique_ptr<Connection>> connect(line::Loop& loop, const model::Line& line,
                                                          const Options& options, const OpenLine& open,
                                                          const line::TrafficFactory& traffic = {});

}  // namespace takt::client
