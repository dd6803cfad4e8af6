// Input of a serial port whose driver marks faulty characters (termios PARMRK).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "takt/wire/character.hpp"

namespace takt::line {

/// Decodes the marks of termios(3) PARMRK: 0xFF 0xFF is the character 0xFF; 0xFF 0x00 X is the character X
/// with a parity or framing error; 0xFF 0x00 0x00 is also a break.
///
/// A frame with a faulty character must be rejected, also with a good checksum (MODBUS over Serial Line,
/// section 2.5.1.1). So X is passed on inverted, which breaks every checksum of this protocol. A break is
/// omitted. Marks may be split over two chunks. One owner, one thread.
class MarkedInput {
public:
    /// Decodes in place. @returns how many bytes are left at the front of `bytes`
    [[nodiscard]] std::size_t decode(std::span<std::uint8_t> bytes);

    /// The character that ends with this byte. Unlike decode(), it has the value that was received, and a
    /// break is a faulty zero.
    [[nodiscard]] std::optional<wire::Character> take(std::uint8_t byte);

    [[nodiscard]] std::uint64_t faulty_characters() const { return faulty_; }
    [[nodiscard]] std::uint64_t breaks() const { return breaks_; }

private:
    enum class State : std::uint8_t { plain, marked, faulty };

    State state_ = State::plain;
    std::uint64_t faulty_ = 0;
    std::uint64_t breaks_ = 0;
};

}  // namespace takt::line
