#include "frames.hpp"

#include <algorithm>
#include <array>

#include "takt/base/ascii.hpp"

namespace takt::sim {
namespace {

using wire::Framing;

constexpr std::size_t kLeastRtu = 4;

constexpr std::array<std::uint16_t, 256> kCrcTable = [] {
    std::array<std::uint16_t, 256> table{};
    for (unsigned i = 0; i < 256; ++i) {
        unsigned crc = i;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xA001U : crc >> 1;
        table[i] = static_cast<std::uint16_t>(crc);
    }
    return table;
}();

unsigned crc_next(unsigned crc, std::uint8_t byte) {
    return crc >> 8 ^ kCrcTable[(crc ^ byte) & 0xFF];
}

unsigned crc_of(Bytes bytes) {
    unsigned crc = 0xFFFF;
    for (const std::uint8_t byte : bytes) crc = crc_next(crc, byte);
    return crc;
}

std::uint8_t sum_of(Bytes bytes) {
    unsigned sum = 0;
    for (const std::uint8_t byte : bytes) sum += byte;
    return static_cast<std::uint8_t>(sum);
}

int digit(std::uint8_t character) {
    if (character >= '0' && character <= '9') return character - '0';
    const int letter = character | 0x20;
    return letter >= 'a' && letter <= 'f' ? letter - 'a' + 10 : -1;
}

/// The bytes of the ASCII frame that begins with the ':' at `start`; nothing if there is none. `end` becomes
/// the offset behind it.
std::optional<ByteString> ascii_at(Bytes bytes, std::size_t start, std::size_t& end) {
    ByteString decoded;
    std::size_t i = start + 1;
    for (; i + 1 < bytes.size() && digit(bytes[i]) >= 0 && digit(bytes[i + 1]) >= 0; i += 2)
        decoded.push_back(static_cast<std::uint8_t>(digit(bytes[i]) << 4 | digit(bytes[i + 1])));
    if (i + 1 >= bytes.size() || bytes[i] != '\r' || bytes[i + 1] != '\n') return {};
    if (decoded.size() < 3 || sum_of(decoded) != 0) return {};
    end = i + 2;
    return decoded;
}

std::size_t request_length(Bytes frame) {
    const auto byte = [frame](std::size_t i) { return i < frame.size() ? std::size_t{frame[i]} : 0; };
    switch (byte(1)) {
        case 0x0F:
        case 0x10: return 9 + byte(6);
        case 0x16: return 10;
        case 0x17: return 13 + byte(10);
        default: return byte(1) >= 1 && byte(1) <= 6 ? 8 : 0;
    }
}

std::size_t response_length(Bytes frame) {
    const std::uint8_t function = frame.size() > 1 ? frame[1] : std::uint8_t{0};
    switch (function) {
        case 0x01:
        case 0x02:
        case 0x03:
        case 0x04:
        case 0x17: return 5 + std::size_t{frame.size() > 2 ? frame[2] : std::uint8_t{0}};
        case 0x05:
        case 0x06:
        case 0x0F:
        case 0x10: return 8;
        case 0x16: return 10;
        default: return wire::is_exception(function) ? 5 : 0;
    }
}

bool equal(Bytes a, Bytes b) {
    return std::ranges::equal(a, b);
}

bool rtu_misleads(Bytes bytes, std::size_t old, bool clean, Bytes genuine, const UnitSet& units) {
    const std::size_t starts = clean ? old : bytes.size();
    for (std::size_t i = 0; i < starts && i + kLeastRtu <= bytes.size(); ++i) {
        if (!units[bytes[i]]) continue;
        const Bytes rest = bytes.subspan(i);
        const std::size_t request = request_length(rest);
        const std::size_t response = response_length(rest);
        unsigned crc = 0xFFFF;
        for (std::size_t length = 1; length <= rest.size(); ++length) {
            crc = crc_next(crc, rest[length - 1]);
            const bool ends = length == request || length == response || length == rest.size();
            if (crc != 0 || !ends || length < kLeastRtu || i + length <= old) continue;
            if (!equal(rest.first(length), genuine)) return true;
        }
    }
    return false;
}

bool ascii_misleads(Bytes bytes, std::size_t old, bool clean, Bytes genuine, const UnitSet& units) {
    std::size_t end = 0;
    const auto sent = genuine.empty() ? std::nullopt : ascii_at(genuine, 0, end);
    const std::size_t starts = clean ? old : bytes.size();
    for (std::size_t i = 0; i < starts; ++i) {
        if (bytes[i] != ':') continue;
        const auto found = ascii_at(bytes, i, end);
        if (found && end > old && units[found->front()] && found != sent) return true;
    }
    return false;
}

}  // namespace

std::optional<OpenFrame> open_frame(Framing framing, Bytes frame) {
    switch (framing) {
        case Framing::rtu:
            if (frame.size() < kLeastRtu || crc_of(frame) != 0) return {};
            return OpenFrame{frame[0], 0, {frame.begin() + 1, frame.end() - 2}};
        case Framing::ascii: {
            std::size_t end = 0;
            const auto decoded = frame.empty() || frame[0] != ':' ? std::nullopt : ascii_at(frame, 0, end);
            if (!decoded || end != frame.size()) return {};
            return OpenFrame{decoded->front(), 0, {decoded->begin() + 1, decoded->end() - 1}};
        }
        case Framing::tcp: break;
    }
    if (frame.size() < 8) return {};
    return OpenFrame{
        frame[6], static_cast<std::uint16_t>(frame[0] << 8 | frame[1]), {frame.begin() + 7, frame.end()}};
}

ByteString close_frame(Framing framing, const OpenFrame& frame) {
    ByteString bytes{frame.unit};
    bytes.insert(bytes.end(), frame.pdu.begin(), frame.pdu.end());
    if (framing == Framing::rtu) {
        const unsigned crc = crc_of(bytes);
        bytes.push_back(static_cast<std::uint8_t>(crc));
        bytes.push_back(static_cast<std::uint8_t>(crc >> 8));
        return bytes;
    }
    if (framing == Framing::tcp) {
        const std::array<std::size_t, 3> words{frame.transaction, 0, bytes.size()};
        ByteString header;
        for (const std::size_t word : words) {
            header.push_back(static_cast<std::uint8_t>(word >> 8));
            header.push_back(static_cast<std::uint8_t>(word));
        }
        bytes.insert(bytes.begin(), header.begin(), header.end());
        return bytes;
    }
    bytes.push_back(static_cast<std::uint8_t>(-sum_of(bytes)));
    ByteString text{':'};
    for (const std::uint8_t byte : bytes)
        for (const unsigned digit : {unsigned{byte} >> 4, unsigned{byte} & 0xF})
            text.push_back(static_cast<std::uint8_t>(hex_digit(digit)));
    text.push_back('\r');
    text.push_back('\n');
    return text;
}

std::size_t answer_length(Framing framing, Bytes pdu) {
    const auto word = [pdu](std::size_t i) {
        return i + 1 < pdu.size() ? std::size_t{pdu[i]} << 8 | pdu[i + 1] : std::size_t{0};
    };
    std::size_t length = 0;
    switch (pdu.empty() ? 0 : pdu[0]) {
        case 0x01:
        case 0x02: length = 2 + (word(3) + 7) / 8; break;
        case 0x03:
        case 0x04:
        case 0x17: length = 2 + 2 * word(3); break;
        case 0x05:
        case 0x06:
        case 0x0F:
        case 0x10: length = 5; break;
        case 0x16: length = 7; break;
        default: return 0;
    }
    return wire::frame_length(framing, length);
}

std::size_t first_response_length(Framing framing, Bytes bytes) {
    constexpr std::size_t kMbapLength = 6;  // with the field itself
    std::size_t length = 0;
    switch (framing) {
        case Framing::rtu: length = response_length(bytes); break;
        case Framing::ascii:
            length = static_cast<std::size_t>(std::ranges::find(bytes, '\n') - bytes.begin()) + 1;
            break;
        case Framing::tcp:
            if (bytes.size() >= kMbapLength) length = kMbapLength + (std::size_t{bytes[4]} << 8 | bytes[5]);
            break;
    }
    return length == 0 ? bytes.size() : std::min(length, bytes.size());
}

bool misleads(Framing framing, Bytes bytes, std::size_t old, bool clean, Bytes genuine,
              const UnitSet& units) {
    switch (framing) {
        case Framing::rtu: return rtu_misleads(bytes, old, clean, genuine, units);
        case Framing::ascii: return ascii_misleads(bytes, old, clean, genuine, units);
        case Framing::tcp: return false;
    }
    return false;
}

}  // namespace takt::sim
