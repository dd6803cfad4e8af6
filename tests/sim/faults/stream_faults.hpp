// Faults of a connection.
#pragma once

#include <deque>
#include <map>

#include "byte_stream.hpp"
#include "fault_injector.hpp"
#include "takt/bus/health.hpp"

namespace takt::sim {

/// Also connects as the real driver does: a closed connection when the client needs it (Engine::opens_at()),
/// a lost one after 250 ms, doubling to 5 s.
class StreamFaults final : public FaultInjector {
public:
    StreamFaults(const model::Line& line, Devices& devices, const FaultPlan& plan, FaultObserver* observer)
        : FaultInjector(line, devices, plan, observer) {}

    using FaultInjector::work_on;
    void work_on(ByteStream& stream) override { stream_ = &stream; }

    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override;
    [[nodiscard]] Instant next_event() const override;
    void on_event(Instant t) override;
    [[nodiscard]] bool on_sent(Instant t, std::size_t sender, Bytes sent,
                               std::vector<Piece>& arrives) override;
    void on_arrived(Instant t, std::size_t sender, Bytes sent, Bytes received) override;
    [[nodiscard]] bool misleads(Bytes, std::size_t, Bytes) override { return false; }
    void on_closed(Instant t) override;

protected:
    std::optional<FaultKind> drawn_for(std::size_t device, Bytes request) override;
    void answering(const Exchange& exchange) override { answers_.push_back(exchange); }
    void device_died(std::size_t device) override;
    void begin(Instant t, FaultKind kind, std::optional<std::size_t> device) override;
    void end(Instant t, FaultKind kind) override;
    void end_all(Instant t) override;
    void begin_anew() override;

private:
    /// @returns whether the frame arrives otherwise than it is
    bool on_frame(Instant t, Bytes frame, std::vector<Piece>& arrives);
    bool spoil(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives);
    /// The answer of a device that is behind with others. @returns whether it is
    bool queue_up(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives);
    void send_later(Instant t, Duration delay, Bytes bytes, std::vector<Piece>& arrives) const;
    void double_up(Instant t, std::size_t device, Bytes frame, std::vector<Piece>& arrives);
    bool send_past(Instant t, std::size_t device, Bytes frame, std::vector<Piece>& arrives);
    void add_glitch(Instant t, Bytes frame, std::vector<Piece>& arrives);
    bool break_up(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives);
    void swallow(Instant t, Instant until);
    void connect(Instant t);
    void back_off(Instant t);
    /// When a connection that was closed is made again; kNever: not now.
    [[nodiscard]] Instant connects_at() const;
    [[nodiscard]] std::optional<FaultKind> closes_for(const serve::Context& context, Bytes request);
    /// The server ends the connection at `when`, if it does not do so before.
    void end_connection_at(Instant when, FaultKind kind, std::optional<std::size_t> device);
    [[nodiscard]] Instant idle_until() const;
    void end_connection(Instant t);

    ByteStream* stream_ = nullptr;
    std::deque<Exchange> answers_;                 // whose answers will come, in this order
    std::map<std::size_t, Instant> behind_until_;  // by device that answers in order
    bool swallows_ = false;
    Instant swallows_until_{};
    struct End {
        Instant when;
        FaultKind kind{};
        std::optional<std::size_t> device;
    };
    std::optional<End> end_;  // of this connection, by the server
    bool backs_off_ = false;  // until the next attempt to connect
    Instant active_at_{};     // when something was sent last
    Instant connected_at_{};
    bus::Backoff backoff_{std::chrono::milliseconds(250), std::chrono::seconds(5)};
};

}  // namespace takt::sim
