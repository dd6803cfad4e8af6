// termios(3), PARMRK: 0xFF 0xFF is the byte 0xFF; 0xFF 0x00 X is the faulty character X; 0xFF 0x00 0x00 is a
// break. A faulty character is passed on inverted, so that the checksum of its frame fails.
#include "loop/marked_input.hpp"

namespace takt::line {

std::optional<wire::Character> MarkedInput::take(std::uint8_t byte) {
    constexpr std::uint8_t kMark = 0xFF;
    switch (state_) {
        case State::plain:
            if (byte != kMark) return wire::Character{byte, false};
            state_ = State::marked;
            return std::nullopt;
        case State::marked:
            state_ = byte == 0 ? State::faulty : State::plain;
            if (byte == 0) return std::nullopt;
            return wire::Character{byte, false};
        case State::faulty: break;
    }
    state_ = State::plain;
    ++(byte == 0 ? breaks_ : faulty_);
    return wire::Character{byte, true};
}

std::size_t MarkedInput::decode(std::span<std::uint8_t> bytes) {
    std::size_t kept = 0;
    for (const std::uint8_t byte : bytes) {
        const auto character = take(byte);
        if (!character || (character->faulty && character->value == 0)) continue;
        bytes[kept++] = character->faulty ? static_cast<std::uint8_t>(~character->value) : character->value;
    }
    return kept;
}

}  // namespace takt::line
