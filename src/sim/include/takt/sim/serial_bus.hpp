// One half-duplex serial line at the level of characters.
#pragma once

#include <cstdint>
#include <vector>

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
    /// @returns its number, 0, 1, 2, … To be called before set_link().
    std::size_t attach(Engine& engine, bool hears_echo = false);

    void set_link(Instant t, bool up) override;
    void run_until(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    void set_observer(WireObserver* observer) override { observer_ = observer; }

private:
    struct Participant {
        Engine* engine = nullptr;
        bool hears_echo = false;
        bool touched = false;               // got bytes or a tick at this moment: may have something to send
        std::vector<std::uint8_t> sending;  // all characters of the transmission; empty: silent
        std::vector<std::uint8_t> heard;    // those of them that were complete, as the others hear them
        std::size_t delivered = 0;
        Instant start;  // of the last transmission, also after its end
        Instant end;
        bool collided = false;
    };

    [[nodiscard]] Instant character_end(const Participant& sender, std::size_t index) const;
    [[nodiscard]] std::size_t chunk_end(const Participant& sender) const;
    [[nodiscard]] bool overlapped(const Participant& sender, Instant from, Instant to) const;
    void step(Instant t);
    void deliver(Participant& sender, Instant t);
    void finish(Participant& sender);
    void collect(Participant& participant, Instant t);

    wire::CharacterFormat format_;
    Options options_;
    WireObserver* observer_ = nullptr;
    std::vector<Participant> participants_;
    Instant now_;
};

}  // namespace takt::sim
