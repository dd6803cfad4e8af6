// One half-duplex serial line at the level of characters.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/sim/disturber.hpp"
#include "takt/sim/wire.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::sim {

/// Everybody hears what anybody sends, each character when its stop bit is over. Who sends does not hear
/// others meanwhile (its driver holds the line). Characters of two senders that overlap in time arrive as
/// other characters. An engine that gives bytes while its earlier ones are still going out sends them right
/// behind, as a UART does.
class SerialBus final : public Wire {
public:
    struct Options {
        /// Characters delivered at a time, as by an adapter that collects them; 0: all of a transmission at
        /// its end (fast). The last ones always come at the end of the transmission.
        std::size_t chunk = 1;
    };

    explicit SerialBus(const wire::CharacterFormat& format) : SerialBus(format, Options{}) {}
    SerialBus(const wire::CharacterFormat& format, const Options& options);

    /// @param engine      outlives the bus
    /// @param hears_echo  also hears itself
    /// @param adapted     hears through the adapter of Options::chunk; else whole transmissions at their end
    /// @returns its number, 0, 1, 2, … To be called before set_link().
    std::size_t attach(Engine& engine, bool hears_echo = false, bool adapted = true);

    void set_link(Instant t, bool up) override;
    /// Of one participant only: it hears nothing and is not heard; the others go on.
    void plug(Instant t, std::size_t participant, bool up);

    /// The participant's computer stands still up to `until`; what it sent goes out, what comes meanwhile it
    /// gets then, at most kBuffer characters of it.
    /// @param late_tick  its timers come before those characters, not after them
    void stall(std::size_t participant, Instant until, bool late_tick);

    /// Somebody who is no participant sends; heard by all who listen. Told to the observers as the sender
    /// behind the last participant.
    void inject(Instant t, Bytes bytes);
    /// Anybody sends; that somebody sends; a participant stands still.
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
        bool hears_echo = false;
        bool adapted = true;
        bool touched = false;               // got bytes or a tick at this moment: may have something to send
        std::vector<std::uint8_t> sending;  // all characters of the transmission; empty: silent
        std::vector<std::uint8_t> heard;    // those of them that were complete, as the others hear them
        std::size_t delivered = 0;
        Instant start;  // of the last transmission, also after its end
        Instant end;
        bool collided = false;
        bool up = false;
        bool disturbed = false;             // others than `sending` go over the line:
        std::vector<std::uint8_t> instead;  // these
        std::optional<Instant> stalled_until;
        bool late_tick = false;
        std::vector<std::uint8_t> buffered;  // came while it stood still

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
    void hear(Participant& sender, std::size_t until);
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
    std::vector<Participant> participants_;  // the last one is the intruder
    std::vector<Piece> pieces_;
    Participant finished_;  // its bytes are told after it is ready to send again
    Instant now_;
};

}  // namespace takt::sim
