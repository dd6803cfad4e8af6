#include "serial/serial_frame.hpp"

#include "takt/base/ascii.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {
namespace {

constexpr std::size_t kLeastRtu = 4;
constexpr std::size_t kLeastAscii = 9;
constexpr std::size_t kAroundDigits = 3;  // ':' and CR LF

bool has_ascii_ends(Bytes frame) {
    return frame.size() >= kLeastAscii && frame[0] == ':' && frame[frame.size() - 2] == '\r' &&
           frame[frame.size() - 1] == '\n';
}

}  // namespace

SerialFrame decode_ascii(Bytes frame) {
    SerialFrame bytes;
    if (!has_ascii_ends(frame)) return {};
    const auto digits = frame.subspan(1, frame.size() - kAroundDigits);
    if (digits.size() % 2 != 0 || digits.size() / 2 > bytes.capacity()) return {};
    for (std::size_t i = 0; i < digits.size(); i += 2) {
        const auto high = hex_value(static_cast<char>(digits[i]));
        const auto low = hex_value(static_cast<char>(digits[i + 1]));
        if (!high || !low) return {};
        bytes.push_back(static_cast<std::uint8_t>(*high << 4U | *low));
    }
    if (bytes.size() < 3 || wire::lrc({bytes.data(), bytes.size() - 1}) != bytes.back()) return {};
    bytes.pop_back();
    return bytes;
}

SerialFrame decode_rtu(Bytes frame) {
    SerialFrame bytes;
    if (frame.size() < kLeastRtu || frame.size() > wire::kMaxRtuFrame) return {};
    const auto body = frame.first(frame.size() - 2);
    const auto sum = static_cast<std::uint16_t>(frame[body.size()] | frame[body.size() + 1] << 8U);
    if (wire::crc16(body) == sum) bytes.assign(body);
    return bytes;
}

SerialFrame decode_serial(Bytes frame) {
    return has_ascii_ends(frame) ? decode_ascii(frame) : decode_rtu(frame);
}

}  // namespace takt::capture
