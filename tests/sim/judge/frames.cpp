#include "frames.hpp"

#include <algorithm>
#include <array>

namespace takt::judge {
namespace {

using Span = std::span<const std::uint8_t>;
using wire::Area;
using wire::Framing;

constexpr std::array<std::uint16_t, 256> kCrcTable = [] {
    std::array<std::uint16_t, 256> table{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned rest = byte;
        for (int bit = 0; bit < 8; ++bit) rest = (rest & 1U) != 0 ? (rest >> 1U) ^ 0xA001U : rest >> 1U;
        table[byte] = static_cast<std::uint16_t>(rest);
    }
    return table;
}();

constexpr unsigned word(Span bytes, std::size_t at) {
    return static_cast<unsigned>(bytes[at] << 8U | bytes[at + 1]);
}
constexpr std::uint16_t word16(Span bytes, std::size_t at) {
    return static_cast<std::uint16_t>(word(bytes, at));
}

// Lower-case digits too, as masters accept them: a damaged character may still be a valid digit.
std::optional<unsigned> hex_digit(std::uint8_t character) {
    if (character >= '0' && character <= '9') return character - '0';
    if (character >= 'A' && character <= 'F') return character - 'A' + 10U;
    if (character >= 'a' && character <= 'f') return character - 'a' + 10U;
    return std::nullopt;
}

/// Address and PDU, without framing.
std::optional<ByteVector> unframe_ascii(Span frame) {
    if (frame.size() < 9 || frame.size() % 2 == 0 || frame[0] != ':' || frame[frame.size() - 2] != '\r' ||
        frame.back() != '\n')
        return std::nullopt;
    ByteVector bytes;
    unsigned sum = 0;
    for (std::size_t i = 1; i + 2 < frame.size(); i += 2) {
        const auto high = hex_digit(frame[i]);
        const auto low = hex_digit(frame[i + 1]);
        if (!high || !low) return std::nullopt;
        bytes.push_back(static_cast<std::uint8_t>(*high << 4U | *low));
        sum += bytes.back();
    }
    if ((sum & 0xFFU) != 0) return std::nullopt;
    bytes.pop_back();
    return bytes;
}

std::optional<ByteVector> unframe_rtu(Span frame) {
    if (frame.size() < 4) return std::nullopt;
    const auto body = frame.first(frame.size() - 2);
    const unsigned check = frame[frame.size() - 2] | static_cast<unsigned>(frame.back()) << 8U;
    if (crc(body) != check) return std::nullopt;
    return ByteVector(body.begin(), body.end());
}

/// The first frame of a stream, by the length in its header.
struct TcpFrame {
    std::uint16_t transaction = 0;
    ByteVector bytes;  // unit, PDU
    std::size_t length = 0;
};
std::optional<TcpFrame> unframe_tcp(Span stream) {
    if (stream.size() < 8 || word(stream, 2) != 0) return std::nullopt;
    const std::size_t length = word(stream, 4);
    if (length < 2 || length > 254 || stream.size() < 6 + length) return std::nullopt;
    const auto body = stream.subspan(6, length);
    return TcpFrame{word16(stream, 0), ByteVector(body.begin(), body.end()), 6 + length};
}

Words bits_of(Span packed, std::size_t count) {
    Words bits(count);
    for (std::size_t i = 0; i < count; ++i)
        bits[i] = static_cast<std::uint16_t>((packed[i / 8] >> (i % 8)) & 1);
    return bits;
}

Words words_of(Span bytes) {
    Words words(bytes.size() / 2);
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = word16(bytes, 2 * i);
    return words;
}

constexpr bool is_bits(Area area) {
    return area == Area::coil || area == Area::discrete_input;
}

std::size_t data_bytes(Area area, std::size_t count) {
    return is_bits(area) ? (count + 7) / 8 : 2 * count;
}

bool take_read(Asked& asked, Span pdu) {
    constexpr std::array kAreas{Area::coil, Area::discrete_input, Area::holding_register,
                                Area::input_register};
    if (pdu.size() != 5) return false;
    asked.reads = true;
    asked.read_area = kAreas[asked.function - 1U];
    asked.read_start = word16(pdu, 1);
    asked.read_count = word16(pdu, 3);
    asked.normal_answer = 2 + data_bytes(asked.read_area, asked.read_count);
    return asked.read_count > 0;
}

bool take_write(Asked& asked, Span pdu) {
    asked.writes = true;
    asked.write_area = asked.function == 5 || asked.function == 15 ? Area::coil : Area::holding_register;
    asked.write_start = word16(pdu, 1);
    asked.normal_answer = 5;
    if (asked.function <= 6) {
        const std::uint16_t value = word16(pdu, 3);
        asked.values = {asked.function == 5 ? static_cast<std::uint16_t>(value == 0xFF00 ? 1 : 0) : value};
        return pdu.size() == 5 && (asked.function == 6 || value == 0xFF00 || value == 0);
    }
    if (pdu.size() < 7) return false;
    const std::size_t count = word(pdu, 3);
    const std::size_t bytes = data_bytes(asked.write_area, count);
    if (pdu[5] != bytes || pdu.size() != 6 + bytes) return false;
    asked.values = is_bits(asked.write_area) ? bits_of(pdu.subspan(6), count) : words_of(pdu.subspan(6));
    return count > 0;
}

bool take_mask(Asked& asked, Span pdu) {
    if (pdu.size() != 7) return false;
    asked.masks = true;
    asked.write_start = word16(pdu, 1);
    asked.and_mask = word16(pdu, 3);
    asked.or_mask = word16(pdu, 5);
    asked.normal_answer = 7;
    return true;
}

bool take_exchange(Asked& asked, Span pdu) {
    if (pdu.size() < 12) return false;
    asked.reads = asked.writes = true;
    asked.read_start = word16(pdu, 1);
    asked.read_count = word16(pdu, 3);
    asked.write_start = word16(pdu, 5);
    const std::size_t count = word(pdu, 7);
    if (pdu[9] != 2 * count || pdu.size() != 10 + 2 * count) return false;
    asked.values = words_of(pdu.subspan(10));
    asked.normal_answer = 2 + 2U * asked.read_count;
    return true;
}

bool take(Asked& asked, Span pdu) {
    switch (asked.function) {
        case 1:
        case 2:
        case 3:
        case 4: return take_read(asked, pdu);
        case 5:
        case 6:
        case 15:
        case 16: return pdu.size() >= 5 && take_write(asked, pdu);
        case 22: return take_mask(asked, pdu);
        case 23: return take_exchange(asked, pdu);
        default: return false;
    }
}

Received judge_pdu(const Asked& asked, Span pdu) {
    Received received;
    if (pdu.empty() || (pdu[0] & 0x7FU) != asked.function) return received;
    received.answer = Answer::odd;
    if ((pdu[0] & 0x80U) != 0) {
        if (pdu.size() != 2) return received;
        received.answer = Answer::exception;
        received.exception = pdu[1];
    } else if (asked.reads) {
        if (pdu.size() != asked.normal_answer || pdu[1] != pdu.size() - 2) return received;
        received.answer = Answer::good;
        received.values =
            is_bits(asked.read_area) ? bits_of(pdu.subspan(2), asked.read_count) : words_of(pdu.subspan(2));
    } else if (pdu.size() == asked.normal_answer && std::equal(pdu.begin(), pdu.end(), asked.pdu.begin())) {
        received.answer = Answer::good;
    }
    return received;
}

Received judge_frame(const Asked& asked, const std::optional<ByteVector>& bytes) {
    if (!bytes || bytes->size() < 2 || bytes->front() != asked.unit) return {};
    return judge_pdu(asked, Span(*bytes).subspan(1));
}

Received find_in_stream(const Asked& asked, Span received) {
    Received best;
    while (const auto frame = unframe_tcp(received)) {
        if (frame->transaction == asked.transaction && best.answer == Answer::none)
            best = judge_frame(asked, frame->bytes);
        received = received.subspan(frame->length);
    }
    return best;
}

}  // namespace

Words values_in(const Asked& asked, Span pdu) {
    return judge_pdu(asked, pdu).values;
}

std::uint16_t crc(Span bytes, std::uint16_t before) {
    unsigned check = before;
    for (const auto byte : bytes) check = check >> 8U ^ kCrcTable[(check ^ byte) & 0xFFU];
    return static_cast<std::uint16_t>(check);
}

std::size_t frame_characters(Framing framing, std::size_t pdu) {
    switch (framing) {
        case Framing::rtu: return 1 + pdu + 2;
        case Framing::ascii: return 1 + 2 * (1 + pdu + 1) + 2;
        case Framing::tcp: return 7 + pdu;
    }
    return 0;
}

std::optional<Asked> parse_request(Framing framing, Span frame) {
    Asked asked;
    std::optional<ByteVector> bytes;
    if (framing == Framing::tcp) {
        auto found = unframe_tcp(frame);
        if (!found || found->length != frame.size()) return std::nullopt;
        asked.transaction = found->transaction;
        bytes = std::move(found->bytes);
    } else {
        bytes = framing == Framing::rtu ? unframe_rtu(frame) : unframe_ascii(frame);
    }
    if (!bytes || bytes->size() < 3) return std::nullopt;
    asked.unit = bytes->front();
    asked.pdu.assign(bytes->begin() + 1, bytes->end());
    asked.function = asked.pdu[0];
    if (!take(asked, asked.pdu)) return std::nullopt;
    return asked;
}

std::size_t complete_frames(Span stream) {
    std::size_t length = 0;
    while (const auto frame = unframe_tcp(stream.subspan(length))) length += frame->length;
    return length;
}

namespace {

/// Characters of the RTU response that begins there; 0: none does. More than there are: incomplete.
std::size_t rtu_response_length(Span bytes) {
    if (bytes.size() < 2) return 3;
    const unsigned function = bytes[1];
    if ((function & 0x80U) != 0) return (function & 0x7FU) == 0 ? 0 : 5;
    if (function >= 1 && function <= 4) return bytes.size() < 3 ? 3 : 5U + bytes[2];
    switch (function) {
        case 5:
        case 6:
        case 15:
        case 16: return 8;
        case 22: return 10;
        case 23: return bytes.size() < 3 ? 3 : 5U + bytes[2];
        default: return 0;
    }
}

std::size_t ascii_response_length(Span bytes) {
    if (bytes.front() != ':') return 0;
    for (std::size_t i = 1; i < bytes.size(); ++i) {
        if (bytes[i] == ':') return 0;
        if (bytes[i] == '\n') return i + 1;
    }
    return bytes.size() + 1;
}

}  // namespace

std::vector<FoundFrame> find_frames(Framing framing, Span bytes, std::size_t& parsed) {
    std::vector<FoundFrame> found;
    std::optional<std::size_t> incomplete;
    std::size_t at = 0;
    while (at < bytes.size()) {
        const auto rest = bytes.subspan(at);
        const bool rtu = framing == Framing::rtu;
        const std::size_t length = rtu ? rtu_response_length(rest) : ascii_response_length(rest);
        if (length > rest.size() && !incomplete) incomplete = at;
        const auto body = length == 0 || length > rest.size() ? std::nullopt
                          : rtu                               ? unframe_rtu(rest.first(length))
                                                              : unframe_ascii(rest.first(length));
        if (!body || body->size() < 2) {
            ++at;
            continue;
        }
        at += length;
        incomplete.reset();  // what began before it was no frame
        found.push_back({at, body->front(), ByteVector(body->begin() + 1, body->end())});
    }
    parsed = incomplete.value_or(bytes.size());
    return found;
}

namespace {

// Behind a frame that only has its unit and function the answer may follow.
bool undecided(const Received& received) {
    return received.answer == Answer::none || received.answer == Answer::odd;
}

}  // namespace

// Usually the answer is everything received. Otherwise other bytes precede or follow it.
Received find_answer(Framing framing, const Asked& asked, Span received) {
    if (framing == Framing::tcp) return find_in_stream(asked, received);
    const bool rtu = framing == Framing::rtu;
    const auto unframe = rtu ? unframe_rtu : unframe_ascii;
    Received found = judge_frame(asked, unframe(received));
    for (std::size_t from = 0; undecided(found) && from < received.size(); ++from)
        for (const std::size_t pdu : {asked.normal_answer, std::size_t{2}}) {
            const std::size_t length = frame_characters(framing, pdu);
            if (!undecided(found) || from + length > received.size()) continue;
            const bool begins =
                rtu ? received[from] == asked.unit && (received[from + 1] & 0x7FU) == asked.function
                    : received[from] == ':';
            if (!begins) continue;
            Received other = judge_frame(asked, unframe(received.subspan(from, length)));
            if (other.answer == Answer::none) continue;
            found = std::move(other);
            found.among_others = received.size() != length;
        }
    return found;
}

}  // namespace takt::judge
