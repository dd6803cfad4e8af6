// A Modbus slave on the UART of a microcontroller.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "takt/firmware/board.hpp"
#include "takt/serve/server.hpp"
#include "takt/wire/frame.hpp"

namespace takt::firmware {

struct SerialDeviceConfig {
    wire::Framing framing = wire::Framing::rtu;  ///< rtu or ascii
    wire::CharacterFormat format;                ///< 300 bit/s at least
    /// RTU: a pause above t1.5 inside a frame drops the frame, and a request begins after a silence only.
    /// false: pauses up to t3.5 are accepted, and a request may follow the response at once. Masters on a
    /// computer, above all behind USB adapters, need that.
    bool strict = false;
    /// RTU: the silence that ends a frame, in microseconds; longer where characters are delivered late. 0, or
    /// less than t3.5: t3.5.
    std::uint32_t frame_silence = 0;
    std::uint8_t port = 0;  ///< of the board
};

/// Receives by interrupts, answers in the main loop and sends by interrupts (MODBUS over Serial Line V1.02,
/// sections 2.5.1.1 and 2.5.2.1). One buffer holds the request, then the response. What is received between
/// the end of a request and that of its response is ignored, as is usual on a half-duplex line: the own echo,
/// too.
///
/// RTU: a UART reports a character at its end. A frame has ended when no character was reported for t3.5 and
/// one character time: then none began within t3.5. ASCII: a frame is dropped after a pause of 1 s.
///
/// The driver of the line is on from before the first character of a response to after its last one.
///
/// No heap. work() belongs to the main loop; the events come from interrupts of one priority.
class SerialDevice final : public BoardEvents {
public:
    /// @param server  outlives it
    SerialDevice(const SerialDeviceConfig& config, serve::Server& server);

    /// @returns false: the board has no such format
    [[nodiscard]] bool start();

    /// Answers the request that has come, if one has. To be called until it returns false; then the main loop
    /// sleeps if has_work() is still false with interrupts masked.
    bool work();
    [[nodiscard]] bool has_work() const { return state_ == State::complete || broken_ != counted_; }

    void on_character(std::uint8_t character, bool damaged) override;
    void on_sent() override;
    void on_timer() override;

private:
    enum class State : std::uint8_t {
        waiting,    // for a silence: nothing is received
        idle,       // a request may begin
        receiving,  // buffer_ holds its beginning
        dropping,   // it is broken; up to its end
        complete,   // buffer_ holds it: the main loop goes on
        sending,    // buffer_ holds the response
    };

    void receive_rtu(std::uint8_t character, bool damaged);
    void receive_ascii(std::uint8_t character, bool damaged);
    void take_digit(std::uint8_t character);
    void begin();
    void append(std::uint8_t byte);
    void drop();
    void end_broken(State next);
    [[nodiscard]] bool ascii() const { return framing_ == wire::Framing::ascii; }
    [[nodiscard]] std::size_t respond();
    [[nodiscard]] std::size_t characters() const;
    [[nodiscard]] std::uint8_t character_to_send(std::size_t index) const;

    serve::Server& server_;
    const wire::CharacterFormat format_;
    const wire::Framing framing_;
    const bool strict_;
    const std::uint8_t port_;
    const std::uint32_t longest_gap_;  // us from the end of a character to that of the next one in its frame
    const std::uint32_t end_gap_;      // us: no character ended for so long: the frame has ended
    std::atomic<State> state_ = State::waiting;
    bool half_ = false;                     // ASCII: the first digit of a byte was received
    bool ending_ = false;                   // ASCII: CR was received
    std::uint32_t last_ = 0;                // when the last character was received
    std::atomic<std::uint8_t> broken_ = 0;  // frames that were dropped, of interrupts
    std::uint8_t counted_ = 0;              // of them, those that the main loop has counted
    std::size_t size_ = 0;                  // bytes in buffer_
    std::size_t sent_ = 0;                  // characters of the response
    std::array<std::uint8_t, wire::kMaxRtuFrame> buffer_{};
};

}  // namespace takt::firmware
