// Frames as a capture that every Wireshark decodes: pcapng (draft-ietf-opsawg-pcapng) with Modbus/TCP.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "takt/base/engine.hpp"

namespace takt::web {

/// One frame, as its line had it.
struct CapturedFrame {
    std::int64_t wall_ns = 0;  ///< ns since 1970
    std::size_t line = 0;      ///< numbers the connections
    bool request = false;
    std::uint8_t unit = 0;
    Bytes pdu;
    std::string_view comment = {};  ///< UTF-8, shown as the packet's comment
};

/// Writes a capture to memory.
///
/// Each line is a TCP connection between 10.0.0.1 and 10.1.x.y, port 502. Each frame is one segment in an
/// IPv4 packet without a link layer, with the Modbus/TCP header in place of address and checksum of a serial
/// line. Sequence numbers and transaction identifiers are those that a connection would have: a response has
/// the identifier of the request before it to the same unit.
class PcapngWriter {
public:
    PcapngWriter();

    void add(const CapturedFrame& frame);
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

private:
    struct Connection {
        std::uint32_t sequence_of_master = 1;
        std::uint32_t sequence_of_slave = 1;
        std::uint16_t last_identifier = 0;
        std::map<std::uint8_t, std::uint16_t> identifiers;  // of the last request to each unit
    };

    [[nodiscard]] std::string packet(const CapturedFrame& frame);
    void block(std::uint32_t type, std::string_view body);

    std::map<std::size_t, Connection> connections_;
    std::string bytes_;
};

}  // namespace takt::web
