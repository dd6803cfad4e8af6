#include "takt/firmware/serial_device.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/firmware/slave_frame.hpp"
#include "takt/wire/silence.hpp"

namespace takt::firmware {
namespace {

constexpr std::uint32_t kSecond = 1'000'000;
constexpr std::uint32_t kAsciiPause = kSecond;
constexpr std::uint32_t kLeastBaud = 300;

// In microseconds, with 32 bits only: a division of 64 bits costs a Cortex-M0 1.5 KB. Rounded down: with the
// delay of the interrupt no gap seems shorter than it is.
std::uint32_t length_of(const wire::CharacterFormat& format, std::uint32_t half_characters) {
    return half_characters * static_cast<std::uint32_t>(format.bits()) * kSecond / (2 * format.baud);
}

// A silence and the character after it.
std::uint32_t gap_with(const wire::CharacterFormat& format, const wire::Silence& silence) {
    constexpr std::uint32_t kNanoseconds = 1000;
    const auto fixed = static_cast<std::uint32_t>(silence.fixed.count()) / kNanoseconds;
    return fixed + length_of(format, static_cast<std::uint32_t>(silence.half_characters) + 2);
}

std::uint32_t end_gap(const SerialDeviceConfig& config) {
    const std::uint32_t character = length_of(config.format, 2);
    if (config.framing == wire::Framing::ascii) return kAsciiPause + character;
    return std::max(gap_with(config.format, wire::silence_between_frames(config.format)),
                    config.frame_silence + character);
}

std::uint32_t longest_gap(const SerialDeviceConfig& config) {
    return config.strict ? gap_with(config.format, wire::silence_in_frame(config.format)) : end_gap(config);
}

constexpr std::uint8_t kNoDigit = 0xFF;

std::uint8_t digit_value(std::uint8_t character) {
    if (character >= '0' && character <= '9') return character - '0';
    if (character >= 'A' && character <= 'F') return character - 'A' + 10;
    return kNoDigit;
}

std::uint8_t digit(unsigned value) {
    return static_cast<std::uint8_t>(value < 10 ? '0' + value : 'A' + value - 10);
}

}  // namespace

SerialDevice::SerialDevice(const SerialDeviceConfig& config, serve::Server& server)
    : server_(server),
      format_(config.format),
      framing_(config.framing),
      strict_(config.strict),
      port_(config.port),
      longest_gap_(longest_gap(config)),
      end_gap_(end_gap(config)) {
    TAKT_ASSERT(config.framing != wire::Framing::tcp && config.format.baud >= kLeastBaud);
}

bool SerialDevice::start() {
    if (!board::open(format_, *this, port_)) return false;
    if (ascii())
        state_ = State::idle;
    else
        board::start_timer(end_gap_, port_);
    return true;
}

// ---- interrupts

void SerialDevice::on_character(std::uint8_t character, bool damaged) {
    switch (state_) {
        case State::complete:
        case State::sending: return;
        case State::waiting: board::start_timer(end_gap_, port_); return;
        case State::idle:
        case State::receiving:
        case State::dropping: break;
    }
    if (ascii())
        receive_ascii(character, damaged);
    else
        receive_rtu(character, damaged);
}

void SerialDevice::receive_rtu(std::uint8_t character, bool damaged) {
    const std::uint32_t now = board::clock();
    const std::uint32_t gap = now - last_;
    last_ = now;
    board::start_timer(end_gap_, port_);
    if (state_ == State::idle)
        begin();
    else if (gap > longest_gap_)
        drop();
    if (damaged) drop();
    append(character);
}

// The parity bit of a damaged ':' or CR may be wrong: the frame before it has no end then.
void SerialDevice::receive_ascii(std::uint8_t character, bool damaged) {
    if (character == ':') {
        if (state_ != State::idle) end_broken(State::idle);
        begin();
        if (damaged) drop();
        board::start_timer(end_gap_, port_);
        return;
    }
    if (state_ == State::idle) return;  // between frames everything is ignored
    board::start_timer(end_gap_, port_);
    if (damaged) drop();
    if (character == '\r' && !ending_) {
        ending_ = true;
    } else if (ending_ && character == '\n') {
        board::stop_timer(port_);
        if (half_) drop();
        if (state_ == State::receiving)
            state_ = State::complete;
        else
            end_broken(State::idle);
    } else if (ending_) {
        drop();
    } else {
        take_digit(character);
    }
}

void SerialDevice::take_digit(std::uint8_t character) {
    const std::uint8_t value = digit_value(character);
    if (value == kNoDigit) drop();
    if (state_ != State::receiving) return;
    if (half_)
        buffer_[size_ - 1] = static_cast<std::uint8_t>(buffer_[size_ - 1] << 4U | value);
    else
        append(value);
    half_ = !half_;
}

void SerialDevice::begin() {
    size_ = 0;
    half_ = ending_ = false;
    state_ = State::receiving;
}

void SerialDevice::append(std::uint8_t byte) {
    if (state_ != State::receiving) return;
    if (size_ == buffer_.size()) return drop();
    buffer_[size_++] = byte;
}

void SerialDevice::drop() {
    state_ = State::dropping;
}

void SerialDevice::end_broken(State next) {
    broken_ = static_cast<std::uint8_t>(broken_ + 1);
    state_ = next;
}

void SerialDevice::on_timer() {
    switch (state_) {
        case State::waiting: state_ = State::idle; return;
        case State::receiving: return ascii() ? end_broken(State::idle) : void(state_ = State::complete);
        case State::dropping: return end_broken(State::idle);
        case State::idle:
        case State::complete:
        case State::sending: return;
    }
}

void SerialDevice::on_sent() {
    if (state_ != State::sending) return;
    if (++sent_ < characters()) return board::send(character_to_send(sent_), port_);
    board::drive_line(false, port_);
    if (ascii() || !strict_) {
        state_ = State::idle;
        return;
    }
    state_ = State::waiting;
    board::start_timer(end_gap_, port_);
}

// ---- main loop

bool SerialDevice::work() {
    while (broken_ != counted_) {
        ++counted_;
        server_.on_line_event(serve::LineEvent::error);
    }
    if (state_ != State::complete) return false;
    size_ = respond();
    if (size_ == 0) {
        state_ = State::idle;
        return true;
    }
    sent_ = 0;
    state_ = State::sending;
    board::drive_line(true, port_);
    board::send(character_to_send(0), port_);
    return true;
}

std::size_t SerialDevice::respond() {
    const Bytes request = Bytes(buffer_).first(size_);
    return ascii() ? respond_ascii(server_, request, buffer_) : respond_rtu(server_, request, buffer_);
}

std::size_t SerialDevice::characters() const {
    constexpr std::size_t kColonAndEnd = 3;
    return ascii() ? 2 * size_ + kColonAndEnd : size_;
}

std::uint8_t SerialDevice::character_to_send(std::size_t index) const {
    if (!ascii()) return buffer_[index];
    if (index == 0) return ':';
    if (index > 2 * size_) return index == 2 * size_ + 1 ? '\r' : '\n';
    const unsigned byte = buffer_[(index - 1) / 2];
    return digit(index % 2 == 1 ? byte >> 4U : byte & 0x0FU);
}

}  // namespace takt::firmware
