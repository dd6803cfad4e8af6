// CRC-16/Modbus, bytewise by table (MODBUS over Serial Line V1.02, section 6.2.2), and the LRC (6.2.1).
#include "checksum.hpp"

#include <array>

#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

constexpr std::uint16_t kReflectedPolynomial = 0xA001;

constexpr auto kTable = [] {
    std::array<std::uint16_t, 256> table{};
    for (unsigned index = 0; index < table.size(); ++index) {
        unsigned crc = index;
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? kReflectedPolynomial : 0U);
        table[index] = static_cast<std::uint16_t>(crc);
    }
    return table;
}();

}  // namespace

std::uint16_t crc16_next(std::uint16_t crc, std::uint8_t byte) {
    return static_cast<std::uint16_t>((crc >> 8) ^ kTable[(crc ^ byte) & 0xFFU]);
}

std::uint16_t crc16(Bytes bytes) {
    std::uint16_t crc = kCrcStart;
    for (const std::uint8_t byte : bytes) crc = crc16_next(crc, byte);
    return crc;
}

std::uint8_t lrc(Bytes bytes) {
    unsigned sum = 0;
    for (const std::uint8_t byte : bytes) sum += byte;
    return static_cast<std::uint8_t>(0U - sum);
}

}  // namespace takt::wire
