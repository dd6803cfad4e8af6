// One direction of Modbus TCP: bytes to application data units.
#pragma once

#include <cstddef>
#include <cstdint>

#include "takt/base/inplace_vector.hpp"
#include "takt/capture/packet.hpp"

namespace takt::capture {

inline constexpr std::size_t kMbapHeaderBytes = 7;  ///< of the MBAP header, with the unit
inline constexpr std::size_t kMbapUnitAt = 6;

/// A message with its MBAP header.
struct Adu {
    std::uint16_t transaction = 0;
    std::uint8_t unit = 0;
    Bytes pdu;         ///< 1..253 bytes, valid during the call; shorter than it was if its packet is cut
    PacketRef packet;  ///< the one that made its last byte available
};

class AduSink {
public:
    virtual void on_adu(const Adu& adu) = 0;

protected:
    ~AduSink() = default;
};

/// Cuts a stream into messages, by the length field of the MBAP header.
///
/// At the begin of a capture, after a gap and after a header that is none, the stream is not aligned. It then
/// searches a message whose header and PDU agree, which is followed by the end of the data or by another
/// header. It prefers one at the begin of a segment. If the stream is certain, that may have any PDU if it is
/// the whole segment. A message found inside of segments whose last byte had come in an earlier packet is
/// dropped, because its time is not known.
///
/// Never allocates. One owner, one thread.
class MbapStream {
public:
    /// @param certain  the port or an option shows that this is Modbus. Otherwise a stream without a message
    ///                 in its first kMostForeign bytes is taken for another protocol and ignored.
    explicit MbapStream(bool certain = false) : certain_(certain) {}
    static constexpr std::size_t kMostForeign = 4096;

    /// The next byte is the first one of the connection.
    void begin_aligned();
    void push(const PacketRef& packet, Bytes bytes, AduSink& sink);
    /// The next byte is any of a message.
    void restart();
    /// Bytes are missing before the next ones.
    void on_gap();
    /// The packet had `count` more bytes, which were not captured. A message that ends with them, and whose
    /// function was captured, is passed with the captured part of its PDU.
    void on_cut(const PacketRef& packet, std::size_t count, AduSink& sink);

    /// The bytes of a message that is not complete, or that are searched. Valid until the next call.
    [[nodiscard]] Bytes pending() const { return {buffer_.data(), buffer_.size()}; }
    [[nodiscard]] bool is_foreign() const { return foreign_; }
    [[nodiscard]] std::uint64_t messages() const { return messages_; }
    [[nodiscard]] std::uint64_t resynchronisations() const { return resynchronisations_; }
    [[nodiscard]] std::uint64_t skipped_bytes() const { return skipped_; }

private:
    static constexpr std::size_t kMostAdu = 260;

    // Each takes bytes of the chunk from `at` on and returns the position behind them.
    [[nodiscard]] std::size_t take(const PacketRef& packet, Bytes chunk, std::size_t at, AduSink& sink);
    [[nodiscard]] std::size_t complete(const PacketRef& packet, Bytes chunk, std::size_t at, AduSink& sink);
    [[nodiscard]] std::size_t search(const PacketRef& packet, Bytes chunk, std::size_t at, AduSink& sink);
    [[nodiscard]] bool is_acceptable(Bytes adu) const;
    void emit(const PacketRef& packet, Bytes adu, AduSink& sink);
    void pass(const PacketRef& packet, Bytes adu, AduSink& sink);
    void lose_alignment();
    void skip(std::size_t count);

    bool certain_;
    bool aligned_ = false;
    bool foreign_ = false;
    std::uint64_t messages_ = 0;
    std::uint64_t resynchronisations_ = 0;
    std::uint64_t skipped_ = 0;
    std::size_t stale_ = 0;  // not aligned: bytes of buffer_ that came in earlier packets
    InplaceVector<std::uint8_t, 2 * kMostAdu>
        buffer_;  // aligned: an incomplete message; else what is searched
};

}  // namespace takt::capture
