// ASCII (MODBUS over Serial Line V1.02, section 2.5.2): ':', two hexadecimal digits a byte, LRC, CR LF.
#include "takt/wire/framer.hpp"

namespace takt::wire {
namespace {

constexpr int kNoDigit = -1;
constexpr std::size_t kLeastBytes = 3;       // unit, function, LRC
constexpr std::size_t kAsciiDelimiters = 3;  // ':', CR, LF

int digit_of(std::uint8_t character) {
    if (character >= '0' && character <= '9') return character - '0';
    if (character >= 'A' && character <= 'F') return character - 'A' + 10;
    if (character >= 'a' && character <= 'f') return character - 'a' + 10;
    return kNoDigit;
}

}  // namespace

FramerStep Framer::push_ascii(Instant t, Bytes bytes) {
    const Duration pause = t - static_cast<Duration::rep>(bytes.size()) * config_.character - last_;
    if (inside() && pause >= config_.ascii_pause) return drop(FrameFault::pause, 0, State::idle);
    if (inside() && too_slow(t)) return drop(FrameFault::too_slow, 0, State::idle);
    if (state_ == State::complete) begin();
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const std::uint8_t character = bytes[i];
        if (character == ':') {
            const bool restarted = inside();
            begin();
            state_ = State::receiving;
            begun_ = t;
            raw_.push_back(character);
            if (restarted) return {i + 1, false, FrameFault::bad_character};
            continue;
        }
        if (state_ == State::idle) continue;
        if (raw_.full()) return drop(FrameFault::too_long, i + 1, State::idle);
        raw_.push_back(character);
        FrameFault fault = FrameFault::none;
        if (state_ == State::ending) {
            if (character == '\n') return end_ascii(i + 1);
            fault = FrameFault::bad_character;
        } else if (character == '\r') {
            state_ = State::ending;
        } else if (!damaged_) {
            fault = take_digit(character);
        }
        // The end of a response that is expected shows whether all of it came.
        damaged_ = damaged_ || (fault == FrameFault::bad_character && expected_);
        if (fault != FrameFault::none && !damaged_) return drop(fault, i + 1, State::idle);
        if (fault == FrameFault::bad_character) state_ = State::receiving;
    }
    return {bytes.size()};
}

FrameFault Framer::take_digit(std::uint8_t character) {
    const int digit = digit_of(character);
    if (digit == kNoDigit) return FrameFault::bad_character;
    const bool first_of_byte = raw_.size() % 2 == 0;  // raw_ begins with ':'
    if (!first_of_byte) {
        decoded_.back() = static_cast<std::uint8_t>(decoded_.back() | digit);
        return FrameFault::none;
    }
    return decoded_.try_push_back(static_cast<std::uint8_t>(digit << 4)) ? FrameFault::none
                                                                         : FrameFault::too_long;
}

FramerStep Framer::end_ascii(std::size_t consumed) {
    const bool whole = expected_ && raw_.size() == expected_->length;
    // Behind a wrong character nothing was decoded; the last byte may lack a digit.
    const Bytes decoded = decoded_.span();
    const bool came =
        whole && is_expected(damaged_ && !decoded.empty() ? decoded.first(decoded.size() - 1) : decoded);
    const auto drop_response = [&](FrameFault fault) {
        FramerStep step = drop(fault, consumed, State::idle);
        step.whole = whole;
        step.came = came;
        return step;
    };
    if (damaged_) return drop_response(FrameFault::bad_character);
    if ((raw_.size() - kAsciiDelimiters) % 2 != 0)
        return drop(FrameFault::bad_character, consumed, State::idle);
    if (decoded_.size() < kLeastBytes) return drop(FrameFault::too_short, consumed, State::idle);
    if (lrc(decoded_.span()) != 0) return drop_response(FrameFault::checksum);
    return complete_frame(consumed);
}

}  // namespace takt::wire
