#include "takt/capture/pcapng_writer.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "takt/capture/pcapng_format.hpp"

namespace takt::capture {
namespace {

template <class T>
void put(std::string& out, T number) {
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(T));
    out.append(bytes.data(), bytes.size());
}

void pad(std::string& out, std::size_t from) {
    while ((out.size() - from) % 4 != 0) out += '\0';
}

void put_option(std::string& out, std::uint16_t code, std::string_view value) {
    put(out, code);
    put(out, static_cast<std::uint16_t>(value.size()));
    const auto from = out.size();
    out += value;
    pad(out, from);
}

void put_number(std::string& out, std::uint16_t code, std::uint64_t number) {
    std::string value;
    put(value, number);
    put_option(out, code, value);
}

void put_time(std::string& out, std::int64_t time_ns) {
    const auto time = static_cast<std::uint64_t>(time_ns);
    put(out, static_cast<std::uint32_t>(time >> 32U));
    put(out, static_cast<std::uint32_t>(time));
}

/// The longest begin of a UTF-8 text that is not cut inside a character.
std::string_view shortened(std::string_view text, std::size_t most) {
    if (text.size() <= most) return text;
    while (most > 0 && (static_cast<unsigned char>(text[most]) & 0xC0U) == 0x80U) --most;
    return text.substr(0, most);
}

/// A block while its body is appended; end() sets both lengths.
class Block {
public:
    Block(std::string& out, std::uint32_t type) : out_(out), at_(out.size()) {
        put(out_, type);
        put(out_, std::uint32_t{0});
    }
    void end() {
        const auto length = static_cast<std::uint32_t>(out_.size() - at_ + sizeof(std::uint32_t));
        std::memcpy(out_.data() + at_ + sizeof(std::uint32_t), &length, sizeof length);
        put(out_, length);
    }

private:
    std::string& out_;
    std::size_t at_;
};

}  // namespace

void append_section(std::string& out) {
    Block block(out, format::kSectionHeader);
    put(out, format::kByteOrderMagic);
    put(out, std::uint16_t{1});  // version 1.0
    put(out, std::uint16_t{0});
    put(out, std::int64_t{-1});  // length not given
    put_option(out, format::kUserApplication, "Takt");
    put_option(out, format::kEndOfOptions, {});
    block.end();
}

void append_interface(std::string& out, LinkType link, std::string_view name) {
    Block block(out, format::kInterface);
    put(out, static_cast<std::uint16_t>(link));
    put(out, std::uint16_t{0});
    put(out, std::uint32_t{0});  // no limit of a packet's length
    put_option(out, format::kInterfaceName, shortened(name, format::kMostInterfaceName));
    put_option(out, format::kTimeResolution, std::string(1, static_cast<char>(format::kNanoseconds)));
    put_option(out, format::kEndOfOptions, {});
    block.end();
}

void append_packet(std::string& out, const WrittenPacket& packet) {
    Block block(out, format::kEnhancedPacket);
    put(out, packet.interface);
    put_time(out, packet.time_ns);
    put(out, static_cast<std::uint32_t>(packet.data.size()));
    put(out, static_cast<std::uint32_t>(std::max(packet.data.size(), packet.original_length)));
    const auto from = out.size();
    out += packet.data;
    pad(out, from);
    const bool directed = packet.direction != PacketDirection::unknown;
    if (!packet.comment.empty()) put_option(out, format::kComment, shortened(packet.comment, kMostComment));
    if (directed) {
        std::string flags;
        put(flags, packet.direction == PacketDirection::sent ? format::kOutbound : format::kInbound);
        put_option(out, format::kPacketFlags, flags);
    }
    if (directed || !packet.comment.empty()) put_option(out, format::kEndOfOptions, {});
    block.end();
}

void append_statistics(std::string& out, const InterfaceStatistics& statistics) {
    Block block(out, format::kInterfaceStatistics);
    put(out, statistics.interface);
    put_time(out, statistics.time_ns);
    put_number(out, format::kReceived, statistics.received);
    put_number(out, format::kDropped, statistics.dropped);
    put_option(out, format::kEndOfOptions, {});
    block.end();
}

}  // namespace takt::capture
