// One direction of a TCP connection: segments to bytes in their order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/capture/packet.hpp"
#include "takt/capture/segment.hpp"

namespace takt::capture {

/// Counts of one direction, or of many.
struct StreamCounts {
    std::uint64_t segments = 0;         ///< with a payload
    std::uint64_t retransmissions = 0;  ///< brought nothing new
    std::uint64_t duplicates = 0;       ///< the same packet captured twice: not a retransmission
    std::uint64_t out_of_order = 0;
    std::uint64_t overlaps = 0;  ///< partly old
    std::uint64_t gaps = 0;      ///< times that bytes are missing in the capture
    std::uint64_t missing_bytes = 0;

    void add(const StreamCounts& other);
};

/// Receives the bytes of a stream.
class StreamSink {
public:
    /// @param packet  the one that made these bytes available to the receiver: for bytes that waited for a
    ///                missing segment, the packet that filled the hole
    virtual void on_data(const PacketRef& packet, Bytes bytes) = 0;
    /// Bytes are missing before the next ones.
    virtual void on_gap() = 0;
    /// The segment of the last bytes had `count` more, which the capture lacks because its packets are cut.
    virtual void on_cut(const PacketRef& packet, std::size_t count) = 0;

protected:
    ~StreamSink() = default;
};

/// Reassembles segments that are cut anywhere, repeated, out of order, overlapping or missing.
///
/// A hole is given up, as a gap, once the receiver has acknowledged bytes behind it: then the segment was
/// delivered but not captured. It is also given up when kMostPending segments or kMostBytes wait behind it.
/// Allocates for segments that wait. One owner, one thread.
class TcpStream {
public:
    static constexpr std::size_t kMostPending = 64;
    static constexpr std::size_t kMostBytes = 128 << 10;

    /// The first byte has that sequence number.
    void begin(std::uint32_t sequence);
    [[nodiscard]] bool begun() const { return begun_; }
    [[nodiscard]] std::uint32_t next() const { return next_; }

    /// The next byte is any: another connection begins. Nothing waits, see flush().
    void forget() { begun_ = has_end_ = false; }
    /// Whether bytes are missing before that number, so that a segment there continues nothing.
    [[nodiscard]] bool is_beyond(std::uint32_t sequence) const;

    /// A segment of this direction with a payload.
    void push(const Segment& segment, const PacketRef& packet, StreamSink& sink);

    /// The other direction acknowledged the bytes before that sequence number.
    void acknowledged(std::uint32_t sequence, StreamSink& sink);

    /// The direction ends behind that sequence number (FIN): its acknowledgement is no gap.
    void end_at(std::uint32_t sequence);

    /// Nothing more comes: passes what waits, as gaps and bytes.
    void flush(StreamSink& sink);

    [[nodiscard]] const StreamCounts& counts() const { return counts_; }

private:
    struct Pending {
        std::uint32_t sequence = 0;
        std::uint32_t length = 0;
        PacketRef packet;
        std::vector<std::uint8_t> payload;
    };
    struct Seen {
        std::uint32_t sequence = 0;
        std::uint16_t identification = 0;
    };

    [[nodiscard]] bool captured_before(const Segment& segment) const;
    void count_old(const Segment& segment);
    void insert(const Segment& segment, const PacketRef& packet);
    void deliver(std::uint32_t sequence, std::uint32_t length, Bytes payload, const PacketRef& packet,
                 StreamSink& sink);
    void deliver_pending(const PacketRef* filler, StreamSink& sink);
    void restart(std::uint32_t sequence, StreamSink& sink);
    void give_up(std::uint32_t until, StreamSink& sink);

    bool begun_ = false;
    bool has_end_ = false;
    std::uint32_t next_ = 0;
    std::uint32_t end_ = 0;
    std::size_t pending_bytes_ = 0;
    std::vector<Pending> pending_;  // by ascending sequence
    Seen seen_[4] = {};             // the last segments
    std::size_t seen_at_ = 0;
    StreamCounts counts_;
};

}  // namespace takt::capture
