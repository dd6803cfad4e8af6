// Constants of the capture formats pcap (draft-ietf-opsawg-pcap) and pcapng (draft-ietf-opsawg-pcapng).
#pragma once

#include <cstddef>
#include <cstdint>

namespace takt::capture::format {

// pcap: the magic number gives the byte order and the unit of the times.
inline constexpr std::uint32_t kMicrosecondMagic = 0xA1B2C3D4;
inline constexpr std::uint32_t kNanosecondMagic = 0xA1B23C4D;
inline constexpr std::size_t kPcapHeader = 24;
inline constexpr std::size_t kPcapRecord = 16;

// pcapng: each block is its type, its length, a body and the length again.
inline constexpr std::uint32_t kSectionHeader = 0x0A0D0D0A;  ///< reads the same in both byte orders
inline constexpr std::uint32_t kByteOrderMagic = 0x1A2B3C4D;
inline constexpr std::uint32_t kInterface = 1;
inline constexpr std::uint32_t kObsoletePacket = 2;
inline constexpr std::uint32_t kSimplePacket = 3;
inline constexpr std::uint32_t kInterfaceStatistics = 5;
inline constexpr std::uint32_t kEnhancedPacket = 6;
inline constexpr std::size_t kBlockFrame = 12;  ///< bytes of a block beside its body

// Options: a code, a length and the value, padded to 4 bytes.
inline constexpr std::uint16_t kEndOfOptions = 0;
inline constexpr std::uint16_t kComment = 1;
inline constexpr std::uint16_t kInterfaceName = 2;
inline constexpr std::uint16_t kPacketFlags = 2;      ///< epb_flags: the direction in the lowest two bits
inline constexpr std::uint16_t kUserApplication = 4;  ///< of a section
inline constexpr std::uint16_t kTimeResolution = 9;   ///< if_tsresol
inline constexpr std::uint16_t kTimeOffset = 14;      ///< if_tsoffset, seconds
inline constexpr std::uint16_t kReceived = 4;         ///< isb_ifrecv
inline constexpr std::uint16_t kDropped = 5;          ///< isb_ifdrop
inline constexpr std::uint32_t kInbound = 1;          ///< of kPacketFlags
inline constexpr std::uint32_t kOutbound = 2;
inline constexpr std::uint8_t kNanoseconds = 9;    ///< if_tsresol: 10^-9 s
inline constexpr std::uint8_t kPowerOfTwo = 0x80;  ///< if_tsresol: a negative power of 2, else of 10

/// Captured bytes of one packet: the greatest length that libpcap writes for common link layers.
inline constexpr std::size_t kMostPacket = 262144;
inline constexpr std::size_t kMostInterfaceName = 256;  ///< bytes; longer names are cut

}  // namespace takt::capture::format
