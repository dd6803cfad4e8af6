// Reads captures: pcap and pcapng, of either byte order, as a stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "takt/capture/packet.hpp"

namespace takt::capture {

/// Why a capture cannot be read, or not to its end.
enum class CaptureFault : std::uint8_t {
    empty,             ///< the file has no bytes
    not_a_capture,     ///< value: the first four bytes as a number, the first byte highest
    compressed,        ///< gzip, zstd, lz4 or xz; value likewise
    version,           ///< value: the major version; allowed: the only one
    byte_order,        ///< a section has another magic number than either order; value: it
    record_length,     ///< value: the length of the record or block; allowed: the greatest
    record_too_short,  ///< value: the length of the record or block; allowed: the least
    length_differs,    ///< the two lengths of a block; value: the second; allowed: the first
    interface,         ///< value: the number of an interface; allowed: how many the section has
    resolution,        ///< if_tsresol; value: the exponent; allowed: the greatest
    incomplete,        ///< the file ends inside a record; value: bytes there; allowed: bytes needed, at least
};
/// "not_a_capture", …
[[nodiscard]] std::string_view name(CaptureFault fault);

struct CaptureError {
    CaptureFault fault{};
    std::uint64_t offset = 0;  ///< of the record in the file, in bytes
    std::uint64_t packet = 0;  ///< the last complete packet before it; 0: none
    std::uint64_t value = 0;
    std::uint64_t allowed = 0;
};

class RecordParser;

/// Cuts the bytes of a file into packets. Its memory does not depend on the size of the file: blocks of other
/// kinds than packets are skipped.
///
///     while (const auto count = read(file, reader.space())) if (!reader.filled(count)) break;
///     reader.end();
///
/// A packet longer than 256 KiB is a fault (record_length). After a fault nothing more is read; the packets
/// before it were passed. Allocates at construction, and for each interface. One owner, one thread.
class CaptureReader {
public:
    explicit CaptureReader(PacketSink& sink);
    ~CaptureReader();
    CaptureReader(const CaptureReader&) = delete;
    CaptureReader& operator=(const CaptureReader&) = delete;

    /// Storage for the next bytes of the file, at least 512 KiB. Valid until filled().
    [[nodiscard]] std::span<std::uint8_t> space();

    /// `count` bytes were stored at the begin of space(). Passes the packets that are complete.
    /// @returns false: there is a fault; the rest of the file is not needed
    bool filled(std::size_t count);

    /// The file has ended. A record that is incomplete is a fault.
    void end();

    [[nodiscard]] const std::optional<CaptureError>& error() const { return error_; }
    [[nodiscard]] std::uint64_t packets() const { return packets_; }
    /// Packets that were lost when the capture was made, by its statistics (pcapng).
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

private:
    friend class RecordParser;

    [[nodiscard]] bool begin();
    bool stop(CaptureFault fault, std::uint64_t value, std::uint64_t allowed = 0);
    bool skip();
    bool parse();

    PacketSink& sink_;
    std::vector<std::uint8_t> buffer_;
    std::size_t begin_ = 0;  // of the bytes that are not parsed yet
    std::size_t end_ = 0;
    std::uint64_t offset_ = 0;  // of begin_ in the file
    std::uint64_t skip_ = 0;    // bytes of a block without interest that have not come yet
    std::uint64_t packets_ = 0;
    std::uint64_t dropped_ = 0;
    std::unique_ptr<RecordParser> parser_;
    std::optional<CaptureError> error_;
};

}  // namespace takt::capture
