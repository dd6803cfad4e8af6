// A gateway at a line that its owner also uses for other things.
#pragma once

#include <functional>
#include <optional>

#include "takt/base/result.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/serve/gateway.hpp"

namespace takt::endpoint {

/// A line that carries relayed requests beside its owner's own, one relayed request at a time. The owner
/// implements it. The loop's thread only.
class SharedLine {
public:
    virtual ~SharedLine() = default;

    [[nodiscard]] virtual bool link_up() const = 0;
    /// Whether submit() may be called: no relayed request is in flight, and its outcome was taken.
    [[nodiscard]] virtual bool can_accept() const = 0;
    /// Whether a request with that response may be sent now. false: the line holds it back, because its
    /// response could be mistaken.
    [[nodiscard]] virtual bool may_start(Instant t, UnitId unit, const bus::AnswerShape& shape) const = 0;
    /// @returns an error: the transaction will not be sent and has no outcome
    [[nodiscard]] virtual Result<void> submit(Instant t, const bus::Transaction& transaction) = 0;
    /// The outcome of the transaction that was submitted, once. Its response is valid until the next
    /// submit().
    [[nodiscard]] virtual std::optional<bus::Outcome> take_outcome() = 0;
    /// Takes the submitted transaction back if it was not sent yet. It then has no outcome.
    /// @returns false: it was sent, or there is none
    [[nodiscard]] virtual bool withdraw() = 0;
    /// Something was submitted: the line's driver is to send it.
    virtual void poke() = 0;
};

/// Moves requests from a gateway to its line, and outcomes back. Pure: it has no timer of its own; its owner
/// calls work() at next_wakeup(), and after_line_event() from inside the line's driver.
class LineGateway {
public:
    using Deliver = std::function<void(const serve::Gateway::Reply&)>;

    /// @param line     outlives it
    /// @param deliver  gets each answer, from inside work() only: a client may send its next request at once
    LineGateway(const serve::GatewayConfig& config, SharedLine& line, Deliver deliver);
    LineGateway(const LineGateway&) = delete;
    LineGateway& operator=(const LineGateway&) = delete;

    [[nodiscard]] serve::Gateway& gateway() { return gateway_; }

    /// Called after each call of the line's engine, before the driver sends: the next request goes out with
    /// the end of the one before. Delivers nothing.
    void after_line_event(Instant t);
    /// Takes the transaction in flight back from the line if it was not sent yet. Its requests wait again.
    void withdraw();
    /// Takes the last outcome from the line, and takes back a transaction that was not sent. After it the
    /// line has no transaction of the gateway. Only while no relayed transaction is in flight.
    void take_back();
    /// Moves all requests and outcomes that can be moved, and delivers the answers.
    void work(Instant t);
    /// When work() is due; `t` or earlier: at once.
    [[nodiscard]] Instant next_wakeup(Instant t) const;

private:
    serve::Gateway gateway_;
    SharedLine& line_;
    Deliver deliver_;
    bool up_ = false;
};

}  // namespace takt::endpoint
