// termios(3), PARMRK: 0xFF 0xFF is the byte 0xFF; 0xFF 0x00 X is the faulty character X; 0xFF 0x00 0x00 is a
// break. A faulty character is passed on inverted, so that the checksum of its frame fails.
#include "takt/line/marked_input.hpp"

namespace takt::line {

std::size_t MarkedInput::decode(std::span<std::uint8_t> bytes) {
    constexpr std::uint8_t kMark = 0xFF;
    std::size_t kept = 0;
    for (const std::uint8_t byte : bytes) {
        switch (state_) {
            case State::plain:
                if (byte == kMark)
                    state_ = State::marked;
                else
                    bytes[kept++] = byte;
                break;
            case State::marked:
                state_ = byte == 0 ? State::faulty : State::plain;
                if (byte != 0) bytes[kept++] = byte;
                break;
            case State::faulty:
                state_ = State::plain;
                if (byte == 0) {
                    ++breaks_;
                } else {
                    ++faulty_;
                    bytes[kept++] = static_cast<std::uint8_t>(~byte);
                }
                break;
        }
    }
    return kept;
}

}  // namespace takt::line
