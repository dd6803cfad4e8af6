// One half-duplex serial line in virtual time, at the level of characters.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/sim/disturber.hpp"
#include "takt/sim/wire.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::sim {

/// All participants receive each character at the end of its stop bit. A transmitting participant does not
/// receive (its driver holds the line). Characters of two senders that overlap in time arrive damaged. Bytes
/// given while earlier ones are still being sent follow them directly, as in a UART.
class SerialBus final : public Wire {
public:
    struct Options {
        /// Characters per delivery, as by an adapter with a buffer; 0: the whole transmission at its end
        /// (fast). The last ones always come at the end of the transmission.
        std::size_t chunk = 1;
    };

    explicit SerialBus(const wire::CharacterFormat& format) : SerialBus(format, Options{}) {}
    SerialBus(const wire::CharacterFormat& format, const Options& options);

    /// @param engine  outlives the bus
    /// @param hears_echo  also receives its own transmissions
    /// @param adapted  receives through the adapter of Options::chunk; else whole transmissions at their end
    /// @returns its number, 0, 1, 2, … To be called before set_link().
    std::size_t attach(Engine& engine, bool receives_echo = false, bool adapted = true);

    void set_link(Instant t, bool up) override;
    /// Disconnects or connects one participant only. The others go on.
    void plug(Instant t, std::size_t participant, bool up);

    /// Suspends the participant's computer until `until`. Its output continues; of its input at most kBuffer
    /// characters are delivered afterwards.
    /// @param late_tick  its timers run before those characters are delivered, not after
    void stall(std::size_t participant, Instant until, bool late_tick);

    /// A sender outside the participants. All connected participants receive it. Observers see the sender
    /// number after the last participant.
    void inject(Instant t, Bytes bytes);
    /// A participant sends these bytes too, behind those that it is sending. It does not receive them.
    void send_from(Instant t, std::size_t participant, Bytes bytes);
    /// Whether any participant sends; whether the outside sender does; whether a participant is suspended.
    [[nodiscard]] bool busy() const;
    [[nodiscard]] bool intrudes() const { return participants_.back().length() > 0; }
    [[nodiscard]] bool stalled(std::size_t participant) const {
        return participants_[participant].stalled_until.has_value();
    }
    [[nodiscard]] std::size_t intruder() const { return participants_.size() - 1; }

    static constexpr std::size_t kBuffer = 4096;

    void set_disturber(Disturber* disturber) override { disturber_ = disturber; }
    void run_until(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    void set_observer(WireObserver* observer) override { observer_ = observer; }

private:
    struct Participant {
        Engine* engine = nullptr;
        bool receives_echo = false;
        bool adapted = true;
        bool touched = false;                // got bytes or a tick at this instant: transmit() is due
        std::vector<std::uint8_t> sending;   // all characters of the transmission; empty: silent
        std::vector<std::uint8_t> received;  // the completed ones, as the others receive them
        std::size_t delivered = 0;
        Instant start;  // of the last transmission, also after its end
        Instant end;
        bool collided = false;
        bool up = false;
        bool disturbed = false;             // others than `sending` go over the line:
        std::vector<std::uint8_t> instead;  // these
        std::optional<Instant> stalled_until;
        bool late_tick = false;
        std::vector<std::uint8_t> buffered;  // received while it was suspended

        [[nodiscard]] const std::vector<std::uint8_t>& characters() const {
            return disturbed ? instead : sending;
        }
        [[nodiscard]] std::size_t length() const { return std::max(sending.size(), characters().size()); }
    };
    class Mute;

    [[nodiscard]] Instant character_end(const Participant& sender, std::size_t index) const;
    [[nodiscard]] std::size_t chunk_end(const Participant& sender) const;
    [[nodiscard]] bool overlapped(const Participant& sender, Instant from, Instant to) const;
    void step(Instant t);
    void deliver(Participant& sender, Instant t);
    void receive(Participant& sender, std::size_t until);
    void make_harmless(Participant& sender, std::size_t before);
    void pass_on(Participant& listener, Instant t, Bytes chunk);
    void finish(Participant& sender, Instant t);
    void collect(Participant& participant, Instant t);
    void send(Participant& participant, Instant t, Bytes bytes);
    void disturb(Participant& participant, Instant t, Bytes bytes);
    void wake(Participant& participant, Instant t);
    void cut_off(Participant& participant);
    [[nodiscard]] Instant wakeup_of(const Participant& participant) const;

    wire::CharacterFormat format_;
    Options options_;
    WireObserver* observer_ = nullptr;
    Disturber* disturber_ = nullptr;
    std::vector<Participant> participants_;  // the last one is the outside sender
    std::vector<Piece> pieces_;
    Participant finished_;  // buffers for reporting a finished transmission
    Instant now_;
};

}  // namespace takt::sim
