// Captures made byte by byte.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "takt/capture/capture_reader.hpp"
#include "takt/capture/pcapng_format.hpp"
#include "takt/capture/segment.hpp"

namespace takt::capture::test {

using Octets = std::vector<std::uint8_t>;

/// "00 01 0a": blanks are ignored.
inline Octets hex(std::string_view text) {
    Octets bytes;
    int high = -1;
    for (const char c : text) {
        if (c == ' ') continue;
        const int digit = c <= '9' ? c - '0' : (c | 0x20) - 'a' + 10;
        if (high < 0) {
            high = digit;
        } else {
            bytes.push_back(static_cast<std::uint8_t>(high * 16 + digit));
            high = -1;
        }
    }
    return bytes;
}

inline Octets joined(std::initializer_list<Octets> parts) {
    Octets all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

inline Octets be(std::uint64_t value, int bytes) {
    Octets octets;
    while (bytes-- > 0) octets.push_back(static_cast<std::uint8_t>(value >> (8 * bytes)));
    return octets;
}

/// A number in the order of a file.
inline Octets number(bool big_endian, std::uint64_t value, int bytes) {
    auto octets = be(value, bytes);
    if (!big_endian) octets = Octets(octets.rbegin(), octets.rend());
    return octets;
}

struct TimedPacket {
    std::int64_t time_ns = 0;
    Octets data;
};

/// A pcap file.
inline Octets pcap(LinkType link, const std::vector<TimedPacket>& packets, bool nanoseconds = true,
                   bool big_endian = false) {
    const auto n = [&](std::uint64_t value, int bytes) { return number(big_endian, value, bytes); };
    auto file = joined({n(nanoseconds ? format::kNanosecondMagic : format::kMicrosecondMagic, 4), n(2, 2),
                        n(4, 2), n(0, 4), n(0, 4), n(65535, 4), n(static_cast<std::uint16_t>(link), 4)});
    for (const auto& [time, data] : packets) {
        const auto fraction = static_cast<std::uint64_t>(time % 1'000'000'000) / (nanoseconds ? 1 : 1000);
        file = joined({file, n(static_cast<std::uint64_t>(time / 1'000'000'000), 4), n(fraction, 4),
                       n(data.size(), 4), n(data.size(), 4), data});
    }
    return file;
}

/// The blocks of pcapng files.
class Pcapng {
public:
    explicit Pcapng(bool big_endian = false) : big_endian_(big_endian) {}

    Pcapng& section() {
        return block(format::kSectionHeader,
                     joined({n(format::kByteOrderMagic, 4), n(1, 2), n(0, 2), n(~0ULL, 8)}));
    }
    Pcapng& interface(LinkType link, const Octets& options = {}, std::uint32_t most = 0) {
        return block(format::kInterface,
                     joined({n(static_cast<std::uint16_t>(link), 2), n(0, 2), n(most, 4), options}));
    }
    /// A resolution option.
    Octets resolution(std::uint8_t value) {
        return joined({n(format::kTimeResolution, 2), n(1, 2), Octets{value, 0, 0, 0}, n(0, 2), n(0, 2)});
    }
    Octets offset(std::int64_t seconds) {
        return joined({n(format::kTimeOffset, 2), n(8, 2), n(static_cast<std::uint64_t>(seconds), 8)});
    }
    Pcapng& packet(std::uint32_t interface, std::uint64_t ticks, const Octets& data) {
        auto padded = data;
        while (padded.size() % 4 != 0) padded.push_back(0);
        return block(format::kEnhancedPacket,
                     joined({n(interface, 4), n(ticks >> 32U, 4), n(ticks & 0xFFFFFFFFU, 4),
                             n(data.size(), 4), n(data.size(), 4), padded}));
    }
    Pcapng& simple(std::uint32_t original, const Octets& data) {
        auto padded = data;
        while (padded.size() % 4 != 0) padded.push_back(0);
        return block(format::kSimplePacket, joined({n(original, 4), padded}));
    }
    Pcapng& block(std::uint32_t type, const Octets& body) {
        const auto length = n(body.size() + format::kBlockFrame, 4);
        bytes = joined({bytes, n(type, 4), length, body, length});
        return *this;
    }

    Octets bytes;

private:
    [[nodiscard]] Octets n(std::uint64_t value, int count) const { return number(big_endian_, value, count); }
    bool big_endian_;
};

/// Fields of a TCP segment in an IPv4 packet. Addresses are 10.0.0.x.
struct TcpFields {
    std::uint8_t from = 1;
    std::uint8_t to = 2;
    std::uint16_t from_port = 40000;
    std::uint16_t to_port = 502;
    std::uint32_t sequence = 0;
    std::uint32_t acknowledged = 0;
    std::uint8_t flags = 0x18;  // PSH, ACK
    std::uint16_t identification = 0;
};

inline Octets ipv4(const TcpFields& f, const Octets& payload) {
    return joined({hex("45 00"),
                   be(40 + payload.size(), 2),
                   be(f.identification, 2),
                   hex("4000 40 06 0000 0a0000"),
                   {f.from},
                   hex("0a0000"),
                   {f.to},
                   be(f.from_port, 2),
                   be(f.to_port, 2),
                   be(f.sequence, 4),
                   be(f.acknowledged, 4),
                   hex("50"),
                   {f.flags},
                   hex("ffff 0000 0000"),
                   payload});
}

/// A message of Modbus TCP.
inline Octets adu(std::uint16_t transaction, std::uint8_t unit, std::string_view pdu) {
    const auto bytes = hex(pdu);
    return joined({be(transaction, 2), hex("0000"), be(bytes.size() + 1, 2), {unit}, bytes});
}

/// Feeds a reader in chunks. @returns whether all was read without a fault
inline bool feed(CaptureReader& reader, const Octets& file, std::size_t chunk = 4096) {
    for (std::size_t at = 0; at < file.size();) {
        const auto space = reader.space();
        const auto count = std::min({chunk, file.size() - at, space.size()});
        std::copy_n(file.begin() + static_cast<std::ptrdiff_t>(at), count, space.begin());
        at += count;
        if (!reader.filled(count)) return false;
    }
    reader.end();
    return !reader.error();
}

}  // namespace takt::capture::test
