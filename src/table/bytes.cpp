#include "takt/table/bytes.hpp"

#include "takt/base/assert.hpp"
#include "takt/table/format.hpp"

namespace takt::table {
namespace {

// Four bits at a time: 64 bytes of constants instead of 1024.
constexpr std::uint32_t kNibbles[16] = {
    0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
    0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C};

}  // namespace

void Crc32::add(std::uint8_t byte) {
    state_ ^= byte;
    state_ = state_ >> 4 ^ kNibbles[state_ & 15];
    state_ = state_ >> 4 ^ kNibbles[state_ & 15];
}

void Crc32::add(Bytes bytes) {
    for (const auto byte : bytes) add(byte);
}

std::uint32_t image_checksum(Bytes image) {
    TAKT_ASSERT(image.size() >= kChecksumOffset + 4);
    Crc32 crc;
    crc.add(image.first(kChecksumOffset));
    for (int i = 0; i < 4; ++i) crc.add(std::uint8_t{0});
    crc.add(image.subspan(kChecksumOffset + 4));
    return crc.value();
}

void seal(std::span<std::uint8_t> image) {
    const auto write = [&](std::size_t offset, std::uint32_t number) {
        for (std::size_t i = 0; i < sizeof number; ++i)
            image[offset + i] = static_cast<std::uint8_t>(number >> (8 * i));
    };
    write(kLengthOffset, static_cast<std::uint32_t>(image.size()));
    write(kChecksumOffset, image_checksum(image));
}

}  // namespace takt::table
