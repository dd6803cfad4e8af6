// Blocks of a pcapng file (draft-ietf-opsawg-pcapng).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "takt/capture/packet.hpp"

namespace takt::capture {

/// Where a packet went, seen from the capturing program.
enum class PacketDirection : std::uint8_t { unknown, received, sent };

/// A packet as append_packet() writes it.
struct WrittenPacket {
    std::uint32_t interface = 0;  ///< number in the section
    std::int64_t time_ns = 0;     ///< since 1970
    PacketDirection direction = PacketDirection::unknown;
    std::string_view data;
    std::size_t original_length = 0;  ///< on the wire; 0: that of `data`
    std::string_view comment{};       ///< UTF-8; kMostComment bytes are kept. Empty: none
};

/// What an interface has lost up to a time.
struct InterfaceStatistics {
    std::uint32_t interface = 0;
    std::int64_t time_ns = 0;
    std::uint64_t received = 0;
    std::uint64_t dropped = 0;
};

inline constexpr std::size_t kMostComment = 2048;

// Each function appends one block to `out`. Numbers have the byte order of this machine, which the magic of
// the section gives. Times are in nanoseconds.

/// The begin of a file. The numbers of interfaces begin again.
void append_section(std::string& out);
/// The next interface of the section. @param name  UTF-8
void append_interface(std::string& out, LinkType link, std::string_view name);
void append_packet(std::string& out, const WrittenPacket& packet);
void append_statistics(std::string& out, const InterfaceStatistics& statistics);

}  // namespace takt::capture
