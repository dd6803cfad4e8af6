// Moves the bytes of an engine over the UART of a board.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "takt/base/engine.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/firmware/board.hpp"
#include "takt/wire/frame.hpp"

namespace takt::firmware {

/// Drives an engine (base/engine.hpp), as the master of a request table. Interrupts collect what is received
/// and send what the engine has given; the main loop calls the engine. The driver of the line is on while
/// characters are sent.
///
/// No heap. work() belongs to the main loop; the events come from interrupts of one priority.
class EnginePort final : public BoardEvents {
public:
    /// Characters that may wait for the main loop. Those beyond are lost: their frame has a wrong checksum.
    static constexpr std::size_t kMostWaiting = 256;

    /// @param engine  outlives it
    /// @param port    of the board
    explicit EnginePort(Engine& engine, unsigned port = 0) : engine_(engine), port_(port) {}

    /// Opens the line. May be called again while nothing is sent, with another format, and with a new engine
    /// in the place of the first one. @returns false: the board has no such format; the line is as before
    [[nodiscard]] bool start(const wire::CharacterFormat& format);
    [[nodiscard]] bool sending() const { return sending_; }

    /// Calls the engine. To be called until it returns false; then the main loop sleeps if has_work() is
    /// still false with interrupts masked.
    bool work();
    [[nodiscard]] bool has_work() const { return received_ != taken_ || timer_passed_ || sent_all_; }

    /// The engine was changed from outside: work() calls it.
    void changed() { timer_passed_ = true; }

    /// The time of the engine now.
    [[nodiscard]] Instant now();

    void on_character(std::uint8_t character, bool damaged) override;
    void on_sent() override;
    void on_timer() override { timer_passed_ = true; }

private:
    void take_received();
    void send_next();

    Engine& engine_;
    unsigned port_;
    Instant now_;
    Instant called_;           // the last time that the engine was given
    std::uint32_t clock_ = 0;  // of the board at now_
    // Indices count on; characters are at their remainders.
    std::array<std::uint8_t, kMostWaiting> ring_{};
    std::atomic<std::uint32_t> received_ = 0;
    std::atomic<std::uint32_t> taken_ = 0;
    std::atomic<std::uint32_t> received_at_ = 0;  // the last character, by the board's clock
    std::atomic<bool> timer_passed_ = false;
    std::atomic<bool> sent_all_ = false;
    std::atomic<bool> sending_ = false;
    bool open_ = false;
    std::size_t sent_ = 0;
    wire::FrameBytes out_;
};

}  // namespace takt::firmware
