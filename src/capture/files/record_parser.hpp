// The records of one capture format.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>

#include "takt/capture/capture_reader.hpp"

namespace takt::capture {

/// The result of reading one record.
struct RecordStep {
    std::size_t needed = 0;    ///< more bytes are needed: so many in all; 0: the record was read
    std::uint64_t length = 0;  ///< of the record; may be greater than the bytes there: the rest is skipped
    std::optional<CaptureError> error = {};  ///< without offset and packet
    bool has_packet = false;
    Packet packet = {};         ///< without its number
    std::uint64_t dropped = 0;  ///< packets that the capture lacks, by statistics since those before
};

/// Reads one record after the other.
class RecordParser {
public:
    virtual ~RecordParser() = default;

    /// @param bytes  from the begin of a record on
    [[nodiscard]] virtual RecordStep read(Bytes bytes) = 0;
};

/// The parser for a file that begins with these bytes (at least four).
/// @returns nullptr: the format is unknown
[[nodiscard]] std::unique_ptr<RecordParser> make_parser(Bytes beginning);

[[nodiscard]] std::unique_ptr<RecordParser> make_pcap_parser(Bytes magic);
[[nodiscard]] std::unique_ptr<RecordParser> make_pcapng_parser();

/// Numbers in the byte order of a file.
class Numbers {
public:
    explicit Numbers(bool swapped = false) : swapped_(swapped) {}
    [[nodiscard]] std::uint16_t u16(const std::uint8_t* at) const { return number<std::uint16_t>(at); }
    [[nodiscard]] std::uint32_t u32(const std::uint8_t* at) const { return number<std::uint32_t>(at); }
    [[nodiscard]] std::uint64_t u64(const std::uint8_t* at) const { return number<std::uint64_t>(at); }

private:
    template <class T>
    [[nodiscard]] T number(const std::uint8_t* at) const {
        T value{};
        std::memcpy(&value, at, sizeof value);
        return swapped_ ? std::byteswap(value) : value;
    }
    bool swapped_;  // against the order of this machine
};

[[nodiscard]] inline RecordStep need(std::size_t bytes) {
    return {.needed = bytes};
}
[[nodiscard]] inline RecordStep fault(CaptureFault kind, std::uint64_t value, std::uint64_t allowed = 0) {
    return {.error = CaptureError{.fault = kind, .value = value, .allowed = allowed}};
}

}  // namespace takt::capture
