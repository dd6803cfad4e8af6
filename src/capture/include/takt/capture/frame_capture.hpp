// Frames of lines as a capture that every Wireshark decodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "takt/base/engine.hpp"
#include "takt/capture/pcapng_writer.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {

/// One frame as its line had it, or bytes that were dropped. Points to data of the caller.
struct CapturedFrame {
    std::int64_t wall_ns = 0;  ///< since 1970
    std::size_t line = 0;      ///< numbers the lines
    std::string_view line_name{};
    wire::Framing framing = wire::Framing::tcp;
    bool request = false;
    PacketDirection direction = PacketDirection::unknown;  ///< seen from this program
    std::uint8_t unit = 0;
    Bytes pdu{};  ///< empty: no frame, see `fault`
    Bytes raw{};  ///< as on the wire; may be empty where `pdu` is not
    /// The addresses of the ends as texts: "192.0.2.7", "192.0.2.7:50100". A text that is none gives a number
    /// of the line: 10.0.0.1 for the client, 10.1.x.y for the server.
    std::string_view client{};
    std::string_view server{};
    std::string_view device{};  ///< its name; empty: unknown
    std::string_view fault{};   ///< why the bytes were dropped; empty: it is a frame
};

/// Makes the blocks of a pcapng file. Each line is an interface of the capture with the line's name.
///
/// A frame is a segment of a TCP connection to port 502 in an IP packet without a link layer, with the real
/// addresses where they are known. The sequence numbers are those of a connection that lost nothing. A frame
/// of a serial line has the header of Modbus TCP in place of its address and checksum: the dissector for RTU
/// cannot distinguish the request of a single write from its response, and there is none for ASCII. Its own
/// bytes are in the comment of the packet. Its transaction identifier is that of the last request to the unit
/// with its function, so that a late response has the one of its request, else that of the last request to
/// the unit.
///
/// Bytes that were dropped are a packet of link type upper_pdu, which Wireshark shows as data.
///
/// Memory is bounded: the least recent of kMostConnections is forgotten. One owner, one thread.
class FrameCapture {
public:
    static constexpr std::size_t kMostConnections = 4096;
    static constexpr std::size_t kMostIdentifiers = 1024;  ///< of a connection; then they are forgotten
    static constexpr std::uint16_t kServerPort = 502;
    /// Between the parts of a comment. The bytes of a serial frame are the last part.
    static constexpr std::string_view kCommentSeparator = " | ";

    /// Begins a file. The connections continue, so that files can be merged.
    void begin_file(std::string& out);

    /// @param out  receives the packet, and before it the interface where the file has it not yet
    void add(const CapturedFrame& frame, std::string& out);

    /// Frames were lost before the next one, which gets a comment about it.
    void add_loss(std::uint64_t count);

    /// Ends a file: statistics of what was captured and lost since it began.
    void end_file(std::int64_t wall_ns, std::string& out);

    /// Since the file began.
    [[nodiscard]] std::uint64_t lost() const { return lost_; }

private:
    struct Connection {
        std::uint64_t used = 0;
        std::uint32_t sequence_of_client = 1;
        std::uint32_t sequence_of_server = 1;
        std::uint16_t last_identifier = 0;
        // Of the last request to each unit with each function, and as function 0 with any one.
        std::map<std::pair<std::uint8_t, std::uint8_t>, std::uint16_t> identifiers;
    };
    using ConnectionKey = std::pair<std::size_t, std::string>;  // line and client

    std::uint32_t interface_of(std::size_t line, LinkType link, std::string_view name, std::string& out);
    Connection& connection_of(const CapturedFrame& frame);
    [[nodiscard]] static std::uint16_t identifier_of(Connection& connection, const CapturedFrame& frame);
    [[nodiscard]] std::string payload_of(Connection& connection, const CapturedFrame& frame);
    [[nodiscard]] std::string segment_of(const CapturedFrame& frame);
    [[nodiscard]] std::string comment_of(const CapturedFrame& frame);

    std::map<std::pair<std::size_t, LinkType>, std::uint32_t> interfaces_;
    std::map<ConnectionKey, Connection> connections_;
    std::uint64_t captured_ = 0;    // in this file
    std::uint64_t lost_ = 0;        // likewise
    std::uint64_t unreported_ = 0;  // lost before the next frame
    std::uint64_t uses_ = 0;        // of connections
};

}  // namespace takt::capture
