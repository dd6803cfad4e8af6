// One direction of RTU or ASCII over TCP: bytes to messages.
#pragma once

#include <cstdint>

#include "network/mbap_stream.hpp"
#include "takt/wire/framer.hpp"

namespace takt::capture {

/// Cuts a stream into frames, as a gateway does: a frame has the length that follows from its first bytes and
/// a good checksum. Bytes that belong to no frame are skipped. Messages have the transaction 0.
///
/// Never allocates. One owner, one thread.
class SerialStream {
public:
    /// @param framing  rtu or ascii
    explicit SerialStream(wire::Framing framing);

    /// The next byte is the first one of the connection, or bytes are missing before it.
    void begin() { framer_.reset(); }
    void push(const PacketRef& packet, Bytes bytes, AduSink& sink);

    [[nodiscard]] std::uint64_t messages() const { return messages_; }
    [[nodiscard]] std::uint64_t skipped_bytes() const { return bytes_ - framed_; }

private:
    wire::StandaloneFramer framer_;
    std::int64_t last_ns_ = 0;
    std::uint64_t messages_ = 0;
    std::uint64_t bytes_ = 0;
    std::uint64_t framed_ = 0;  // of bytes_, in messages
};

}  // namespace takt::capture
