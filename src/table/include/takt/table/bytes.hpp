// Little-endian numbers in an image, and its checksum.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <type_traits>

#include "takt/base/engine.hpp"

namespace takt::table {

/// CRC-32 (IEEE 802.3: polynomial 0xEDB88320 reflected, start and final xor 0xFFFFFFFF), byte by byte.
class Crc32 {
public:
    void add(std::uint8_t byte);
    void add(Bytes bytes);
    [[nodiscard]] std::uint32_t value() const { return ~state_; }

private:
    std::uint32_t state_ = 0xFFFF'FFFF;
};

/// The checksum of an image: that of all its bytes, those of the checksum itself taken as 0.
/// image.size() >= kChecksumOffset + 4
std::uint32_t image_checksum(Bytes image);

/// Writes the length and the checksum into the header of an image; shared by both formats.
/// image.size() >= kChecksumOffset + 4
void seal(std::span<std::uint8_t> image);

/// A number of an image as an unsigned integer of its size.
template <class T>
using Raw =
    std::conditional_t<sizeof(T) == 1, std::uint8_t,
                       std::conditional_t<sizeof(T) == 2, std::uint16_t,
                                          std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;

/// Takes numbers one after the other; the bytes must be there.
class Take {
public:
    explicit Take(const std::uint8_t* bytes) : bytes_(bytes) {}

    template <class T>
    void operator()(T& number) {
        std::uint64_t raw = 0;
        for (std::size_t i = 0; i < sizeof(T); ++i) raw |= std::uint64_t{*bytes_++} << (8 * i);
        number = std::bit_cast<T>(static_cast<Raw<T>>(raw));
    }

private:
    const std::uint8_t* bytes_;
};

/// Appends numbers one after the other to a container of bytes.
template <class Container>
class Put {
public:
    explicit Put(Container& bytes) : bytes_(bytes) {}

    template <class T>
    void operator()(const T& number) {
        const auto raw = std::uint64_t{std::bit_cast<Raw<T>>(number)};
        for (std::size_t i = 0; i < sizeof(T); ++i)
            bytes_.push_back(static_cast<std::uint8_t>(raw >> (8 * i)));
    }

private:
    Container& bytes_;
};

}  // namespace takt::table
