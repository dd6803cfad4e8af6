#include "damage.hpp"

#include <algorithm>

namespace takt::sim {
namespace {

constexpr std::size_t kMostGarbage = 300;
constexpr std::size_t kMostData = 255;  // the greatest byte count

std::size_t place(Random& random, std::size_t count) {
    return random.below(static_cast<std::uint32_t>(count));
}

auto iterator_at(ByteString& bytes, std::size_t index) {
    return bytes.begin() + static_cast<std::ptrdiff_t>(index);
}

std::uint8_t other_unit(Random& random, const UnitSet& units, std::uint8_t own) {
    const bool of_the_line = random.below(2) == 0;
    for (int tries = 0; tries < 1000; ++tries) {
        const auto unit = static_cast<std::uint8_t>(1 + random.below(255));
        if (unit != own && units[unit] == of_the_line) return unit;
    }
    std::uint8_t unit = own;
    do ++unit;
    while (units[unit] || unit == 0);
    return unit;
}

/// Changes the number of data bytes of a read response, and its byte count accordingly.
void resize_data(Random& random, OpenFrame& answer, std::size_t size) {
    answer.pdu.resize(2);
    answer.pdu[1] = static_cast<std::uint8_t>(size);
    const ByteString data = any_bytes(random, size);
    answer.pdu.insert(answer.pdu.end(), data.begin(), data.end());
}

std::size_t fewer_or_more(Random& random, std::size_t size) {
    constexpr std::size_t kAllowed = 250;
    const std::size_t step = 1 + place(random, 4);
    const bool more = size <= step || (random.below(2) == 0 && size + step <= kAllowed);
    return more ? size + step : size - step;
}

}  // namespace

std::uint8_t any_byte(Random& random) {
    return static_cast<std::uint8_t>(random.next() >> 56);
}

ByteString any_bytes(Random& random, std::size_t count) {
    ByteString bytes(count);
    std::ranges::generate(bytes, [&] { return any_byte(random); });
    return bytes;
}

std::uint16_t other_transaction(Random& random, std::uint16_t own) {
    constexpr std::uint16_t kFar = 0x4000;
    std::uint16_t made = 0;
    switch (random.below(6)) {
        case 0: break;
        case 1: made = static_cast<std::uint16_t>(own + 1); break;
        case 2: made = static_cast<std::uint16_t>(own - 1); break;
        case 3: made = static_cast<std::uint16_t>(own << 8U | own >> 8U); break;
        default: made = own ^ kFar; break;
    }
    return made != own ? made : own ^ kFar;
}

ByteString copy_of(Random& random, wire::Framing framing, Bytes frame) {
    if (framing == wire::Framing::tcp && random.below(2) == 0) {
        if (auto open = open_frame(framing, frame)) {
            open->transaction = other_transaction(random, open->transaction);
            return close_frame(framing, *open);
        }
    }
    return {frame.begin(), frame.end()};
}

ByteString spoil_characters(Random& random, FaultKind kind, Bytes frame) {
    ByteString bytes(frame.begin(), frame.end());
    const std::size_t where = place(random, bytes.size());
    switch (kind) {
        case FaultKind::lost_byte: bytes.erase(iterator_at(bytes, where)); break;
        case FaultKind::repeated_byte: bytes.insert(iterator_at(bytes, where), bytes[where]); break;
        case FaultKind::extra_byte:
            bytes.insert(iterator_at(bytes, place(random, bytes.size() + 1)), any_byte(random));
            break;
        default:
            for (std::uint32_t bits = 1 + random.below(3); bits > 0; --bits)
                bytes[place(random, bytes.size())] ^= static_cast<std::uint8_t>(1U << random.below(8));
            if (std::ranges::equal(bytes, frame)) bytes[where] ^= 1;
            break;
    }
    return bytes;
}

ByteString cut_short(Random& random, Bytes frame) {
    if (frame.size() < 2) return {};
    const Bytes kept = frame.first(1 + place(random, frame.size() - 1));
    return {kept.begin(), kept.end()};
}

ByteString garbage_for(Random& random, wire::Framing framing, Bytes frame) {
    const std::size_t size = random.below(2) == 0 ? frame.size() : 1 + place(random, kMostGarbage);
    ByteString bytes = any_bytes(random, std::max<std::size_t>(size, 8));
    if (framing != wire::Framing::tcp) return bytes;
    if (random.below(2) == 0) {  // a wrong protocol identifier
        bytes[2] |= 1;
        return bytes;
    }
    // The header is valid. The function code exists neither as a request nor as an exception.
    OpenFrame nonsense{frame[6], static_cast<std::uint16_t>(frame[0] << 8 | frame[1]),
                       any_bytes(random, 1 + place(random, 200))};
    nonsense.pdu[0] = static_cast<std::uint8_t>((nonsense.pdu[0] & wire::kExceptionBit) | 0x60);
    return close_frame(framing, nonsense);
}

bool alters(FaultKind kind, Bytes request_pdu, const OpenFrame& answer) {
    const std::uint8_t function = request_pdu.empty() ? std::uint8_t{0} : request_pdu[0];
    const bool normal = answer.pdu[0] == function;
    const auto& shape = wire::properties(wire::Function{function});
    switch (kind) {
        case FaultKind::wrong_unit:
        case FaultKind::wrong_transaction:
        case FaultKind::wrong_function: return true;
        case FaultKind::wrong_byte_count:
        case FaultKind::oversized: return normal && shape.returns_items();
        case FaultKind::wrong_echo: return normal && shape.echoes();
        default: return false;
    }
}

void alter(Random& random, FaultKind kind, const UnitSet& units, OpenFrame& answer) {
    ByteString& pdu = answer.pdu;
    switch (kind) {
        case FaultKind::wrong_unit: answer.unit = other_unit(random, units, answer.unit); break;
        case FaultKind::wrong_transaction:
            answer.transaction = other_transaction(random, answer.transaction);
            break;
        case FaultKind::wrong_function:
            pdu[0] = static_cast<std::uint8_t>((pdu[0] & wire::kExceptionBit) |
                                               (wire::requested_function(pdu[0]) ^ (1U + random.below(63))));
            break;
        case FaultKind::wrong_byte_count:
            resize_data(random, answer, fewer_or_more(random, pdu.size() - 2));
            break;
        case FaultKind::oversized:
            resize_data(random, answer,
                        std::min(kMostData, pdu.size() + place(random, kMostData + 3 - pdu.size())));
            break;
        default:
            pdu[1 + place(random, pdu.size() - 1)] ^= static_cast<std::uint8_t>(1U << random.below(8));
            break;
    }
}

}  // namespace takt::sim
