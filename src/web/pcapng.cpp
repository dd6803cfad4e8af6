// Numbers of pcapng blocks have the byte order of this machine, which the magic of the section says; those of
// packets are in network order.
#include "pcapng.hpp"

#include <array>
#include <cstring>

#include "takt/capture/packet.hpp"
#include "takt/capture/pcapng_format.hpp"

namespace takt::web {
namespace {

namespace format = capture::format;

constexpr std::uint16_t kModbusPort = 502;
constexpr std::uint16_t kFirstMasterPort = 49152;
constexpr std::size_t kMostComment = 1024;

template <class T>
void put(std::string& out, T number) {
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(T));
    out.append(bytes.data(), bytes.size());
}

void pad(std::string& out) {
    while (out.size() % 4 != 0) out += '\0';
}

void put_option(std::string& out, std::uint16_t code, std::string_view value) {
    put(out, code);
    put(out, static_cast<std::uint16_t>(value.size()));
    out += value;
    pad(out);
}

void put_be16(std::string& out, std::uint32_t number) {
    out += static_cast<char>((number >> 8U) & 0xFFU);
    out += static_cast<char>(number & 0xFFU);
}

void put_be32(std::string& out, std::uint32_t number) {
    put_be16(out, number >> 16U);
    put_be16(out, number & 0xFFFFU);
}

/// The Internet checksum (RFC 1071).
std::uint16_t checksum(std::string_view bytes, std::uint32_t sum = 0) {
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
        const auto high = static_cast<unsigned char>(bytes[i]);
        const auto low = i + 1 < bytes.size() ? static_cast<unsigned char>(bytes[i + 1]) : 0U;
        sum += (std::uint32_t{high} << 8U) | low;
    }
    while (sum > 0xFFFF) sum = (sum & 0xFFFFU) + (sum >> 16U);
    return static_cast<std::uint16_t>(~sum);
}

void set_be16(std::string& out, std::size_t at, std::uint16_t number) {
    out[at] = static_cast<char>(number >> 8U);
    out[at + 1] = static_cast<char>(number & 0xFFU);
}

std::string tcp_header(bool request, std::size_t line, std::uint32_t sequence, std::uint32_t acknowledged) {
    const auto master_port = static_cast<std::uint16_t>(kFirstMasterPort + line % 16384);
    std::string tcp;
    put_be16(tcp, request ? master_port : kModbusPort);
    put_be16(tcp, request ? kModbusPort : master_port);
    put_be32(tcp, sequence);
    put_be32(tcp, acknowledged);
    put_be16(tcp, 0x5018);  // five words; PSH, ACK
    put_be16(tcp, 64240);   // window
    put_be32(tcp, 0);       // checksum, urgent pointer
    return tcp;
}

/// Without its checksum.
std::string ip_header(std::uint32_t from, std::uint32_t to, std::size_t payload) {
    std::string ip;
    put_be16(ip, 0x4500);
    put_be16(ip, static_cast<std::uint32_t>(20 + payload));
    put_be32(ip, 0x00004000);  // no fragments
    put_be32(ip, 0x40060000);  // time to live 64, TCP
    put_be32(ip, from);
    put_be32(ip, to);
    return ip;
}

}  // namespace

PcapngWriter::PcapngWriter() {
    std::string section;
    put(section, format::kByteOrderMagic);
    put(section, std::uint16_t{1});  // version 1.0
    put(section, std::uint16_t{0});
    put(section, std::int64_t{-1});  // length not given
    put_option(section, format::kUserApplication, "Takt");
    put_option(section, format::kEndOfOptions, {});
    block(format::kSectionHeader, section);
    std::string interface;
    put(interface, static_cast<std::uint16_t>(capture::LinkType::raw));
    put(interface, std::uint16_t{0});
    put(interface, std::uint32_t{0});  // no limit of a packet's length
    put_option(interface, format::kInterfaceName, "takt");
    put_option(interface, format::kTimeResolution, std::string(1, static_cast<char>(format::kNanoseconds)));
    put_option(interface, format::kEndOfOptions, {});
    block(format::kInterface, interface);
}

void PcapngWriter::block(std::uint32_t type, std::string_view body) {
    const auto length = static_cast<std::uint32_t>(format::kBlockFrame + body.size());
    put(bytes_, type);
    put(bytes_, length);
    bytes_ += body;
    put(bytes_, length);
}

std::string PcapngWriter::packet(const CapturedFrame& frame) {
    auto& connection = connections_[frame.line];
    if (frame.request) connection.identifiers[frame.unit] = ++connection.last_identifier;
    const auto known = connection.identifiers.find(frame.unit);
    const std::uint16_t identifier =
        known == connection.identifiers.end() ? ++connection.last_identifier : known->second;

    std::string payload;
    put_be16(payload, identifier);
    put_be16(payload, 0);
    put_be16(payload, static_cast<std::uint32_t>(frame.pdu.size() + 1));
    payload += static_cast<char>(frame.unit);
    payload.append(reinterpret_cast<const char*>(frame.pdu.data()), frame.pdu.size());

    auto& own = frame.request ? connection.sequence_of_master : connection.sequence_of_slave;
    const auto other = frame.request ? connection.sequence_of_slave : connection.sequence_of_master;
    auto segment = tcp_header(frame.request, frame.line, own, other) + payload;
    own += static_cast<std::uint32_t>(payload.size());

    const std::uint32_t master = 0x0A000001;
    const std::uint32_t slave = 0x0A010001U + static_cast<std::uint32_t>(frame.line % 65000);
    auto ip = ip_header(frame.request ? master : slave, frame.request ? slave : master, segment.size());
    const std::uint32_t pseudo = (master >> 16U) + (master & 0xFFFFU) + (slave >> 16U) + (slave & 0xFFFFU) +
                                 6 + static_cast<std::uint32_t>(segment.size());
    set_be16(segment, 16, checksum(segment, pseudo));
    set_be16(ip, 10, checksum(ip));
    return ip + segment;
}

void PcapngWriter::add(const CapturedFrame& frame) {
    const auto data = packet(frame);
    const auto time = static_cast<std::uint64_t>(frame.wall_ns);
    std::string body;
    put(body, std::uint32_t{0});  // interface
    put(body, static_cast<std::uint32_t>(time >> 32U));
    put(body, static_cast<std::uint32_t>(time));
    put(body, static_cast<std::uint32_t>(data.size()));
    put(body, static_cast<std::uint32_t>(data.size()));
    body += data;
    pad(body);
    if (!frame.comment.empty()) {
        put_option(body, format::kComment, frame.comment.substr(0, kMostComment));
        put_option(body, format::kEndOfOptions, {});
    }
    block(format::kEnhancedPacket, body);
}

}  // namespace takt::web
