// Headers of IPv4 (RFC 791), IPv6 (RFC 8200) and TCP (RFC 9293) without options.
#include "network/ip_packet.hpp"

#include "files/big_endian.hpp"

namespace takt::capture {
namespace {

constexpr std::size_t kTcpChecksum = 16;
constexpr std::size_t kIpChecksum = 10;
constexpr std::size_t kIpv4InAddress = 12;  // position in IpAddress::bytes

void set16(std::string& out, std::size_t at, std::uint16_t number) {
    out[at] = static_cast<char>(number >> 8U);
    out[at + 1] = static_cast<char>(number & 0xFFU);
}

std::string_view address_bytes(const IpAddress& address) {
    const std::string_view bytes(reinterpret_cast<const char*>(address.bytes.data()), address.bytes.size());
    return address.is_ipv4() ? bytes.substr(kIpv4InAddress) : bytes;
}

/// The sum of 16-bit words of the Internet checksum (RFC 1071), not folded.
std::uint32_t sum_of(std::string_view bytes, std::uint32_t sum) {
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
        const std::uint32_t high = static_cast<unsigned char>(bytes[i]);
        const std::uint32_t low = i + 1 < bytes.size() ? static_cast<unsigned char>(bytes[i + 1]) : 0U;
        sum += high << 8U | low;
    }
    return sum;
}

std::uint16_t checksum(std::uint32_t sum) {
    while (sum > 0xFFFF) sum = (sum & 0xFFFFU) + (sum >> 16U);
    return static_cast<std::uint16_t>(~sum);
}

std::string tcp_segment(const TcpHead& head, std::string_view payload) {
    std::string tcp;
    put_be16(tcp, head.source.port);
    put_be16(tcp, head.destination.port);
    put_be32(tcp, head.sequence);
    put_be32(tcp, head.acknowledged);
    put_be16(tcp, 0x5018);  // five words; PSH, ACK
    put_be16(tcp, 64240);   // window
    put_be32(tcp, 0);       // checksum, urgent pointer
    tcp += payload;
    std::uint32_t sum = kTcpProtocol + static_cast<std::uint32_t>(tcp.size());  // of the pseudo header
    sum = sum_of(address_bytes(head.source.address), sum);
    sum = sum_of(address_bytes(head.destination.address), sum);
    set16(tcp, kTcpChecksum, checksum(sum_of(tcp, sum)));
    return tcp;
}

}  // namespace

std::string tcp_packet(const TcpHead& head, std::string_view payload) {
    const auto segment = tcp_segment(head, payload);
    const auto length = static_cast<std::uint32_t>(segment.size());
    const bool version4 = head.source.address.is_ipv4();
    std::string ip;
    if (version4) {
        put_be16(ip, 0x4500);
        put_be16(ip, kIpv4HeaderBytes + length);
        put_be32(ip, 0x00004000);                                       // no fragments
        put_be32(ip, 0x40000000 | std::uint32_t{kTcpProtocol} << 16U);  // time to live 64
    } else {
        put_be32(ip, 0x60000000);
        put_be16(ip, length);
        put_be16(ip, kTcpProtocol << 8U | 64U);  // hop limit
    }
    ip += address_bytes(head.source.address);
    ip += address_bytes(head.destination.address);
    if (version4) set16(ip, kIpChecksum, checksum(sum_of(ip, 0)));
    return ip + segment;
}

}  // namespace takt::capture
