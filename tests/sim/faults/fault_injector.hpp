// Carries out a FaultPlan on one simulated line.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "faults.hpp"
#include "frames.hpp"
#include "takt/model/project.hpp"
#include "takt/sim/devices.hpp"
#include "takt/sim/disturber.hpp"

namespace takt::sim {

/// Connects a simulated line's wire, slave engine and devices; made and driven by SimulatedLine. This base
/// class has the parts common to serial lines and connections: the draw for an exchange, the devices, the
/// clock.
class FaultInjector : public LineFaults {
public:
    FaultInjector(const FaultInjector&) = delete;
    FaultInjector& operator=(const FaultInjector&) = delete;

    /// Scheduled faults are drawn from the first start on.
    void run(Instant t, bool on) override;

    [[nodiscard]] const FaultCounts& counts() const { return counts_; }

    [[nodiscard]] bool serves(UnitId unit) const override { return devices_.serves(unit); }
    void on_line_event(serve::LineEvent event) override { devices_.on_line_event(event); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override;
    [[nodiscard]] Instant next_event() const override { return next_event_; }
    void on_event(Instant t) override;

protected:
    /// @param line      need not outlive it
    /// @param devices   those of the line, in its order; outlive it
    /// @param observer  may be nullptr; outlives it
    FaultInjector(const model::Line& line, Devices& devices, const FaultPlan& plan, FaultObserver* observer);

    /// An answer, from the moment when its device has it.
    struct Exchange {
        std::optional<std::size_t> device;
        std::optional<FaultKind> kind;
        wire::Pdu request;
        std::size_t normal_length = 0;  ///< characters of a normal answer
        Instant deadline;               ///< the master waits for its last character at least until then
        bool dropped = false;           ///< its device has died meanwhile
    };

    // For the line's kind of wire.
    /// The faults drawn when the request was sent. If none were drawn then, draws now.
    virtual std::optional<FaultKind> drawn_for(std::size_t device, Bytes request) = 0;
    virtual void answering(const Exchange& exchange) = 0;
    /// Takes an answer that will not be sent in its time. @returns whether it did
    virtual bool postpone(Instant, const Exchange&, UnitId, const serve::Answer&) { return false; }
    virtual void device_died(std::size_t device) = 0;
    virtual void begin(Instant t, FaultKind kind, std::optional<std::size_t> device) = 0;
    virtual void end(Instant t, FaultKind kind) = 0;
    virtual void end_all(Instant t) = 0;
    virtual void begin_anew() {}  // the line was started or stopped from outside

    [[nodiscard]] std::optional<FaultKind> draw(std::optional<std::size_t> device);
    [[nodiscard]] std::optional<std::size_t> device_of(std::uint8_t unit) const;
    [[nodiscard]] bool silent(std::size_t device) const { return states_[device].silent; }
    [[nodiscard]] std::uint32_t per_million(FaultKind kind) const {
        return quiet_ ? 0 : plan_.rates.per_million[static_cast<std::size_t>(kind)];
    }
    void count(Instant t, FaultKind kind, std::optional<std::size_t> device,
               std::optional<Instant> until = {});
    void recovered(std::size_t device);

    /// Draws the next start of a scheduled kind.
    void schedule(Instant t, FaultKind kind, std::optional<std::size_t> device);
    void schedule_end(Instant when, FaultKind kind, std::optional<std::size_t> device);
    void schedule_begin(Instant when, FaultKind kind, std::optional<std::size_t> device);
    [[nodiscard]] Duration duration(const DurationRange& range) {
        return random_.between(range.least, range.most);
    }

    /// Changes the answer, for kinds that do so.
    /// @returns whether `instead` replaces it; false: the kind does not concern this answer
    [[nodiscard]] bool spoil_answer(FaultKind kind, const Exchange& exchange, Bytes sent,
                                    std::vector<std::uint8_t>& instead);
    /// Characters that cannot be taken for a frame (see misleads()), drawn repeatedly; nothing if no draw
    /// succeeds.
    std::vector<std::uint8_t> harmless(const std::function<std::vector<std::uint8_t>()>& make, Bytes genuine);
    /// misleads(), together with the previously received characters.
    [[nodiscard]] bool could_mislead(Bytes fresh, bool clean, Bytes genuine) const;
    /// A valid frame directly behind damaged characters.
    [[nodiscard]] bool lost_for_what_was_before(Bytes frame);
    void remember(Bytes received, bool good);

    // The drawn times of answers that do not come in their time.
    [[nodiscard]] Duration lateness(std::size_t device);
    [[nodiscard]] Duration copy_delay();
    /// Whether the device that answers with a copy serves the request again, before those that follow it.
    [[nodiscard]] bool serves_again(std::size_t device);
    [[nodiscard]] Duration service_time();
    [[nodiscard]] bool in_order(std::size_t device) const {
        return device >= plan_.out_of_order.size() || !plan_.out_of_order[device];
    }
    /// An earlier answer of that device with the same function and length, and other bytes; empty: none.
    [[nodiscard]] ByteString past_answer(std::size_t device, Bytes sent);
    void note_sent(std::size_t device, Bytes sent);
    /// One to three disturbing characters.
    [[nodiscard]] ByteString glitch_for(Bytes frame, bool before);
    void note_answer(Bytes received);
    wire::Framing framing_;
    wire::CharacterFormat format_;
    bool serial_;
    Devices& devices_;
    FaultPlan plan_;
    FaultObserver* observer_;
    Random random_;
    FaultCounts counts_;
    UnitSet units_;                   // those of the line, and 0
    std::vector<std::uint8_t> tail_;  // damaged characters since the last valid request
    bool running_ = false;
    bool quiet_ = false;

private:
    struct State {
        FaultRates rates;
        std::uint32_t sum = 0;  // per million, of all kinds by exchange
        Duration wait{};
        Duration response_timeout{};
        bool silent = false;
        std::deque<ByteString> sent;  // its last answers
        std::uint64_t ailing = 0;     // kinds since its last valid answer
    };
    struct Timer {
        Instant when;
        FaultKind kind{};
        std::optional<std::size_t> device;
        bool ends = false;
    };

    [[nodiscard]] State state_of(const model::Device& device, std::size_t index) const;
    [[nodiscard]] Exchange exchange_of(const serve::Context& context, std::size_t device,
                                       Bytes request) const;
    void delay_answer(const Exchange& exchange, serve::Answer& answer);
    void add(const Timer& timer);
    void fire(Instant t, const Timer& timer);
    void silence(Instant t, FaultKind kind, std::size_t device);
    void revive(Instant t, FaultKind kind, std::size_t device);
    void fall_quiet(Instant t);
    void update_next_event();

    std::array<std::int16_t, 256> index_of_unit_{};
    std::vector<State> states_;
    bool started_ = false;
    std::uint64_t line_ailing_ = 0;
    std::vector<Timer> timers_;
    Instant next_event_ = kNever;
};

}  // namespace takt::sim
