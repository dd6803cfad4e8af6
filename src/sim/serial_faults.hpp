// Faults of a serial line.
#pragma once

#include "fault_injector.hpp"
#include "takt/sim/serial_bus.hpp"

namespace takt::sim {

/// For a bus with the master (0) and all devices (1) as participants.
class SerialFaults final : public FaultInjector {
public:
    SerialFaults(const model::Line& line, Devices& devices, const FaultPlan& plan, FaultObserver* observer);

    /// Before anything happens on it; it outlives the faults.
    void work_on(SerialBus& bus) { bus_ = &bus; }

    [[nodiscard]] bool on_sent(Instant t, std::size_t sender, Bytes sent,
                               std::vector<Piece>& arrives) override;
    void on_arrived(Instant t, std::size_t sender, Bytes sent, Bytes received) override;
    [[nodiscard]] bool misleads(Bytes received, std::size_t old, Bytes sent) override;
    void on_closed(Instant) override {}

protected:
    std::optional<FaultKind> drawn_for(std::size_t device, Bytes request) override;
    void answering(const Exchange& exchange) override;
    void device_died(std::size_t device) override;
    void begin(Instant t, FaultKind kind, std::optional<std::size_t> device) override;
    void end(Instant t, FaultKind kind) override;
    void end_all(Instant t) override;
    bool late_answer_waits(std::uint8_t unit) const override;

private:
    struct Station {
        std::optional<FaultKind> drawn;    // for the request on its way
        std::optional<Exchange> exchange;  // whose answer is on its way
    };

    bool on_request(Instant t, Bytes sent, std::vector<Piece>& arrives);
    bool on_answer(Instant t, Bytes sent, std::vector<Piece>& arrives);
    bool spoil_request(Instant t, FaultKind kind, std::optional<std::size_t> device, Bytes sent,
                       std::vector<Piece>& arrives);
    [[nodiscard]] std::optional<std::size_t> addressee(Bytes frame, bool& broadcast) const;
    void babble(Instant t);

    SerialBus* bus_ = nullptr;
    std::vector<Station> stations_;
    Instant babbles_until_{};
};

}  // namespace takt::sim
