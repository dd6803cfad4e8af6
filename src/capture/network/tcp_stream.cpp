// Sequence numbers are compared modulo 2^32 (RFC 9293, section 3.4).
#include "takt/capture/tcp_stream.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>

namespace takt::capture {
namespace {

// No window in Modbus traffic is larger. Numbers further away belong to another connection, or to a part of
// this one that was not captured.
constexpr std::int32_t kFarAway = 1 << 20;

std::int32_t distance(std::uint32_t from, std::uint32_t to) {
    return static_cast<std::int32_t>(to - from);
}

bool is_far(std::uint32_t from, std::uint32_t to) {
    return std::abs(std::int64_t{distance(from, to)}) > kFarAway;
}

}  // namespace

void StreamCounts::add(const StreamCounts& other) {
    segments += other.segments;
    retransmissions += other.retransmissions;
    duplicates += other.duplicates;
    out_of_order += other.out_of_order;
    overlaps += other.overlaps;
    gaps += other.gaps;
    missing_bytes += other.missing_bytes;
}

void TcpStream::begin(std::uint32_t sequence) {
    begun_ = true;
    has_end_ = false;
    next_ = sequence;
}

bool TcpStream::is_beyond(std::uint32_t sequence) const {
    return begun_ && (distance(next_, sequence) > 0 || is_far(next_, sequence));
}

bool TcpStream::captured_before(const Segment& segment) const {
    if (segment.identification == 0) return false;
    return std::ranges::any_of(seen_, [&](const Seen& seen) {
        return seen.identification == segment.identification && seen.sequence == segment.sequence;
    });
}

// A keep-alive repeats at most the last byte that was acknowledged (RFC 9293, section 3.8.4).
void TcpStream::count_old(const Segment& segment) {
    const bool keep_alive = segment.length == 1 && distance(segment.sequence, next_) == 1;
    if (captured_before(segment))
        ++counts_.duplicates;
    else if (!keep_alive)
        ++counts_.retransmissions;
}

void TcpStream::push(const Segment& segment, const PacketRef& packet, StreamSink& sink) {
    ++counts_.segments;
    if (!begun_) begin(segment.sequence);
    if (is_far(next_, segment.sequence)) restart(segment.sequence, sink);
    if (distance(next_, segment.sequence + segment.length) <= 0) {
        count_old(segment);
    } else if (distance(next_, segment.sequence) > 0) {
        insert(segment, packet);
        if (pending_.size() > kMostPending || pending_bytes_ > kMostBytes)
            give_up(pending_.front().sequence, sink);
    } else {
        if (segment.sequence != next_) ++counts_.overlaps;
        deliver(segment.sequence, segment.length, segment.payload, packet, sink);
        deliver_pending(&packet, sink);
    }
    seen_[seen_at_] = {segment.sequence, segment.identification};
    seen_at_ = (seen_at_ + 1) % std::size(seen_);
}

void TcpStream::insert(const Segment& segment, const PacketRef& packet) {
    const auto place = std::ranges::find_if(
        pending_, [&](const Pending& pending) { return distance(segment.sequence, pending.sequence) >= 0; });
    if (place != pending_.end() && place->sequence == segment.sequence && place->length >= segment.length)
        return count_old(segment);
    ++counts_.out_of_order;
    pending_bytes_ += segment.payload.size();
    pending_.insert(place, {segment.sequence, segment.length, packet,
                            std::vector(segment.payload.begin(), segment.payload.end())});
}

/// Passes the bytes from next_ on; the segment begins there or before.
void TcpStream::deliver(std::uint32_t sequence, std::uint32_t length, Bytes payload, const PacketRef& packet,
                        StreamSink& sink) {
    const std::uint32_t old = next_ - sequence;
    const auto fresh = payload.subspan(std::min<std::size_t>(old, payload.size()));
    next_ = sequence + length;
    if (!fresh.empty()) sink.on_data(packet, fresh);
    if (payload.size() < length) {  // the packet was cut when it was captured
        const auto missing = length - std::max<std::size_t>(payload.size(), old);
        ++counts_.gaps;
        counts_.missing_bytes += missing;
        sink.on_cut(packet, missing);
    }
}

/// Passes waiting segments that are next. @param filler  the packet that closed the hole before them;
/// nullptr: none did, their own packets count
void TcpStream::deliver_pending(const PacketRef* filler, StreamSink& sink) {
    std::size_t passed = 0;
    for (; passed < pending_.size() && distance(pending_[passed].sequence, next_) >= 0; ++passed) {
        const auto& pending = pending_[passed];
        pending_bytes_ -= pending.payload.size();
        if (distance(next_, pending.sequence + pending.length) <= 0) continue;
        deliver(pending.sequence, pending.length, pending.payload, filler ? *filler : pending.packet, sink);
    }
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(passed));
}

/// Continues at an unrelated number.
void TcpStream::restart(std::uint32_t sequence, StreamSink& sink) {
    flush(sink);
    ++counts_.gaps;
    sink.on_gap();
    begin(sequence);
}

void TcpStream::give_up(std::uint32_t until, StreamSink& sink) {
    ++counts_.gaps;
    counts_.missing_bytes += until - next_;
    next_ = until;
    sink.on_gap();
    deliver_pending(nullptr, sink);
}

void TcpStream::acknowledged(std::uint32_t sequence, StreamSink& sink) {
    if (!begun_) return;
    if (has_end_ && sequence == end_ + 1) sequence = end_;
    while (distance(next_, sequence) > 0) {
        if (pending_.empty() && distance(next_, sequence) > kFarAway) return;
        const bool waits = !pending_.empty() && distance(pending_.front().sequence, sequence) >= 0;
        give_up(waits ? pending_.front().sequence : sequence, sink);
    }
}

void TcpStream::end_at(std::uint32_t sequence) {
    has_end_ = true;
    end_ = sequence;
}

void TcpStream::flush(StreamSink& sink) {
    while (!pending_.empty()) give_up(pending_.front().sequence, sink);
}

}  // namespace takt::capture
