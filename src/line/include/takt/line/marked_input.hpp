// Input of a serial port whose driver marks faulty characters (termios PARMRK).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace takt::line {

/// Takes the marks out of the input: 0xFF 0xFF is the character 0xFF, 0xFF 0x00 x a character x that
/// arrived with a parity or framing error, 0xFF 0x00 0x00 also a break.
///
/// A frame with a faulty character must not be believed (MODBUS over Serial Line, section 2.5.1.1),
/// whatever its checksum says; so x is handed on inverted, which no checksum of this protocol survives. A
/// break is left out. Marks may be cut by the end of a chunk. One owner, one thread.
class MarkedInput {
public:
    /// Decodes in place. @returns how many bytes are left at the front of `bytes`
    [[nodiscard]] std::size_t decode(std::span<std::uint8_t> bytes);

    [[nodiscard]] std::uint64_t faulty_characters() const { return faulty_; }
    [[nodiscard]] std::uint64_t breaks() const { return breaks_; }

private:
    enum class State : std::uint8_t { plain, marked, faulty };

    State state_ = State::plain;
    std::uint64_t faulty_ = 0;
    std::uint64_t breaks_ = 0;
};

}  // namespace takt::line
