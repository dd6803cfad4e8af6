// Faults of a serial line.
#pragma once

#include "fault_injector.hpp"
#include "serial_bus.hpp"

namespace takt::sim {

/// For a bus with the master (0) and all devices (1) as participants.
class SerialFaults final : public FaultInjector {
public:
    SerialFaults(const model::Line& line, Devices& devices, const FaultPlan& plan, FaultObserver* observer);

    using FaultInjector::work_on;
    void work_on(SerialBus& bus) override { bus_ = &bus; }

    [[nodiscard]] bool on_sent(Instant t, std::size_t sender, Bytes sent,
                               std::vector<Piece>& arrives) override;
    void on_arrived(Instant t, std::size_t sender, Bytes sent, Bytes received) override;
    [[nodiscard]] bool misleads(Bytes received, std::size_t old, Bytes sent) override;
    void on_closed(Instant) override {}

protected:
    std::optional<FaultKind> drawn_for(std::size_t device, Bytes request) override;
    void answering(const Exchange& exchange) override;
    bool postpone(Instant t, const Exchange& exchange, UnitId unit, const serve::Answer& answer) override;
    void device_died(std::size_t device) override;
    void begin(Instant t, FaultKind kind, std::optional<std::size_t> device) override;
    void end(Instant t, FaultKind kind) override;
    void end_all(Instant t) override;

private:
    struct Station {
        std::optional<FaultKind> drawn;    // for the request on its way
        std::optional<Exchange> exchange;  // whose answer is on its way
    };

    /// Bytes that a device sends at its own time.
    struct Later {
        Instant when;
        std::size_t device = 0;
        std::optional<FaultKind> kind;  // counted when it is sent
        bool waits_for_silence = false;
        bool again = false;  // the request is served twice
        ByteString bytes;
    };

    void send_later(Instant when, std::size_t device, std::optional<FaultKind> kind, Bytes bytes);
    void send_due(Instant t, std::size_t device);
    [[nodiscard]] Duration length(Bytes bytes) const {
        return wire::transmission_time(format_, bytes.size());
    }
    bool copy(Instant t, std::size_t device, Bytes sent, ByteString& instead);
    bool send_past(Instant t, std::size_t device, Bytes sent, ByteString& instead);
    bool add_glitch(Instant t, std::size_t device, Bytes sent, ByteString& instead);
    bool on_request(Instant t, Bytes sent, std::vector<Piece>& arrives);
    bool on_answer(Instant t, Bytes sent, std::vector<Piece>& arrives);
    bool spoil_request(Instant t, FaultKind kind, std::optional<std::size_t> device, Bytes sent,
                       std::vector<Piece>& arrives);
    [[nodiscard]] std::optional<std::size_t> addressee(Bytes frame, bool& broadcast) const;
    void babble(Instant t);

    SerialBus* bus_ = nullptr;
    std::vector<Station> stations_;
    Instant babbles_until_{};
    std::vector<Later> later_;  // of a device that answers in order: in this order
    bool sending_later_ = false;
};

}  // namespace takt::sim
