// One connection of a load.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "takt/base/engine.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/client/load.hpp"
#include "takt/line/driver.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::client {

/// A transaction engine that takes the next request of its load whenever it has room. The load outlives it.
///
/// Over Framing::tcp it recognises late responses itself, by their transaction id: the engine remembers only
/// a few requests of one kind.
class LoadConnection final : public Engine, private wire::TrafficObserver {
public:
    LoadConnection(Load& load, const bus::LineConfig& config)
        : load_(load), numbered_(config.framing == wire::Framing::tcp), engine_(config, this) {}

    [[nodiscard]] Result<void> open(const model::Line& line, const OpenLine& open_line);
    [[nodiscard]] bool up() const { return driver_ && driver_->up(); }
    [[nodiscard]] const std::optional<Error>& link_error() const { return link_error_; }

    [[nodiscard]] bool has_room() const {
        return engine_.can_submit() && flights_.size() < load_.options_.in_flight;
    }
    /// Takes one request that is due. There is room.
    void take_one(Instant t);
    void poke() { driver_->poke(); }
    /// Records what is still open: late responses did not come, requests in flight have none yet.
    void end(Instant t);

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override { return engine_.transmit(t); }
    [[nodiscard]] std::optional<Error> rejection() const override { return engine_.rejection(); }
    /// Over Framing::tcp: frames that answered no request, in time or late.
    [[nodiscard]] std::uint64_t unexpected() const;
    [[nodiscard]] Instant next_wakeup() const override { return engine_.next_wakeup(); }

private:
    static constexpr std::size_t kMostTimedOut = 256;
    static constexpr std::size_t kMostReceived = 8;
    struct Flight {
        std::uint64_t number = 0;
        Instant intended;
        Instant sent_at{};
        Instant request_end{};
        std::uint16_t wire_id = 0;
    };
    struct Received {
        Instant at;
        wire::Pdu pdu;
    };

    void on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) override;
    void on_fault(Instant, wire::FrameFault, Bytes) override {}
    void proceed(Instant t);
    void conclude(const bus::Outcome& outcome);
    void answered(const Flight& flight, Instant end, std::uint8_t exception);
    void answered_late(const Flight& flight, Instant end, Bytes pdu);
    void no_response(const Flight& flight, capture::NoResponse why);
    void take_late();
    [[nodiscard]] wire::Pdu take_received(Instant at);
    [[nodiscard]] bool may_answer(const Flight& flight, std::uint16_t wire_id) const;
    void compare(Bytes pdu);

    Load& load_;
    bool numbered_;  // Framing::tcp
    bus::TransactionEngine engine_;
    std::unique_ptr<line::Driver> driver_;
    std::optional<Error> link_error_;
    InplaceVector<Flight, bus::kMaxInFlight> flights_;
    InplaceVector<Flight, kMostTimedOut> timed_out_;   // may be answered late
    std::uint64_t late_ = 0;                           // Framing::tcp: recognised late responses
    InplaceVector<Received, kMostReceived> received_;  // serial line: the last frames, the oldest first
};

}  // namespace takt::client
