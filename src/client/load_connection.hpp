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

namespace takt::client {

/// A transaction engine that takes the next request of its load whenever it has room. The load outlives it.
class LoadConnection final : public Engine {
public:
    LoadConnection(Load& load, const bus::LineConfig& config) : load_(load), engine_(config) {}

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
    [[nodiscard]] Instant next_wakeup() const override { return engine_.next_wakeup(); }

private:
    struct Flight {
        std::uint64_t number = 0;
        Instant intended;
        Instant sent_at{};
        Instant request_end{};
    };

    void proceed(Instant t);
    void conclude(const bus::Outcome& outcome);
    void answered(const Flight& flight, Instant end, std::uint8_t exception);
    void no_response(const Flight& flight, capture::NoResponse why);
    void take_late();
    void compare(Bytes pdu);

    Load& load_;
    bus::TransactionEngine engine_;
    std::unique_ptr<line::Driver> driver_;
    std::optional<Error> link_error_;
    InplaceVector<Flight, bus::kMaxInFlight> flights_;
    InplaceVector<Flight, bus::TransactionStorageOf<1>::kOutstanding> timed_out_;  // may be answered late
};

}  // namespace takt::client
