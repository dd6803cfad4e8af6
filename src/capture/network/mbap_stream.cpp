// The MBAP header: transaction (2 bytes), protocol (2 bytes, 0), length of the rest (2 bytes), unit. MODBUS
// Messaging on TCP/IP Implementation Guide V1.0b, section 3.1.3.
#include "network/mbap_stream.hpp"

#include <algorithm>

#include "exchanges/pdu_shape.hpp"
#include "files/big_endian.hpp"

namespace takt::capture {
namespace {

constexpr std::size_t kLengthEnd = 6;     // of the header up to its length field
constexpr std::uint8_t kLeastLength = 2;  // unit and function
constexpr std::uint8_t kMostLength = 254;

/// Whether the bytes can begin a header, as far as they are there.
bool can_begin_header(Bytes bytes) {
    for (std::size_t i = 2; i < std::min<std::size_t>(bytes.size(), kLengthEnd - 1); ++i)
        if (bytes[i] != 0) return false;
    return bytes.size() < kLengthEnd || (bytes[5] >= kLeastLength && bytes[5] <= kMostLength);
}

std::size_t adu_length(Bytes header) {
    return kLengthEnd + header[5];
}

bool is_plausible(Bytes pdu) {
    return could_be_request(pdu) || could_be_response(pdu);
}

enum class Judgement { impossible, incomplete, message };

/// Whether a message begins here, with the end of the data or another header behind it.
Judgement judge(Bytes bytes) {
    if (!can_begin_header(bytes)) return Judgement::impossible;
    if (bytes.size() < kLengthEnd || bytes.size() < adu_length(bytes)) return Judgement::incomplete;
    const auto length = adu_length(bytes);
    if (!is_plausible(bytes.subspan(kMbapHeaderBytes, length - kMbapHeaderBytes)))
        return Judgement::impossible;
    return can_begin_header(bytes.subspan(length)) ? Judgement::message : Judgement::impossible;
}

/// Whether the bytes are one message, by its length field only: its function may be that of a vendor.
bool is_one_message(Bytes bytes) {
    return bytes.size() > kMbapHeaderBytes && can_begin_header(bytes) && bytes.size() == adu_length(bytes);
}

}  // namespace

void MbapStream::begin_aligned() {
    aligned_ = true;
    buffer_.clear();
}

void MbapStream::push(const PacketRef& packet, Bytes bytes, AduSink& sink) {
    stale_ = buffer_.size();
    for (std::size_t at = 0; at < bytes.size() && !foreign_;)
        at = aligned_ ? take(packet, bytes, at, sink) : search(packet, bytes, at, sink);
}

std::size_t MbapStream::take(const PacketRef& packet, Bytes chunk, std::size_t at, AduSink& sink) {
    if (!buffer_.empty()) return complete(packet, chunk, at, sink);
    const auto rest = chunk.subspan(at);
    if (rest.size() < kLengthEnd) {
        buffer_.append(rest);
        return chunk.size();
    }
    if (!can_begin_header(rest)) {
        stale_ = 0;
        lose_alignment();
        return at;
    }
    const auto length = adu_length(rest);
    if (rest.size() < length) {
        buffer_.append(rest);
        return chunk.size();
    }
    emit(packet, rest.first(length), sink);
    return at + length;
}

std::size_t MbapStream::complete(const PacketRef& packet, Bytes chunk, std::size_t at, AduSink& sink) {
    const Bytes begun(buffer_.data(), buffer_.size());
    const auto needed = (begun.size() < kLengthEnd ? kLengthEnd : adu_length(begun)) - begun.size();
    const auto count = std::min(needed, chunk.size() - at);
    stale_ = buffer_.size();
    buffer_.append(chunk.subspan(at, count));
    at += count;
    if (buffer_.size() == kLengthEnd && !can_begin_header({buffer_.data(), buffer_.size()})) {
        lose_alignment();
    } else if (count == needed && buffer_.size() > kLengthEnd) {
        emit(packet, {buffer_.data(), buffer_.size()}, sink);
        if (aligned_) buffer_.clear();
    }
    return at;
}

std::size_t MbapStream::search(const PacketRef& packet, Bytes chunk, std::size_t at, AduSink& sink) {
    if (at == 0 && (judge(chunk) == Judgement::message || (certain_ && is_one_message(chunk)))) {
        skip(buffer_.size());
        begin_aligned();
        return at;
    }
    const auto added = std::min(chunk.size() - at, buffer_.capacity() - buffer_.size());
    buffer_.append(chunk.subspan(at, added));
    at += added;
    const Bytes all(buffer_.data(), buffer_.size());
    std::size_t begin = 0;
    for (; begin < all.size(); ++begin) {
        const auto rest = all.subspan(begin);
        const auto judgement = judge(rest);
        if (judgement == Judgement::incomplete) break;
        if (judgement == Judgement::impossible) continue;
        const auto length = adu_length(rest);
        if (begin + length > stale_) {
            const auto behind = rest.size() - length;  // bytes of this chunk
            skip(begin);
            emit(packet, rest.first(length), sink);
            begin_aligned();
            return at - behind;
        }
        begin += length - 1;
    }
    skip(begin);
    buffer_.drop_front(begin);
    stale_ -= std::min(begin, stale_);
    return at;
}

bool MbapStream::is_acceptable(Bytes adu) const {
    return messages_ > 0 || certain_ || is_plausible(adu.subspan(kMbapHeaderBytes));
}

void MbapStream::emit(const PacketRef& packet, Bytes adu, AduSink& sink) {
    if (!is_acceptable(adu)) {
        aligned_ = false;
        skip(adu.size());
        buffer_.clear();
        return;
    }
    pass(packet, adu, sink);
}

void MbapStream::pass(const PacketRef& packet, Bytes adu, AduSink& sink) {
    ++messages_;
    sink.on_adu({.transaction = be16_at(adu, 0),
                 .unit = adu[kMbapUnitAt],
                 .pdu = adu.subspan(kMbapHeaderBytes),
                 .packet = packet});
}

void MbapStream::on_gap() {
    if (aligned_) lose_alignment();
    restart();
}

void MbapStream::restart() {
    aligned_ = false;
    skip(buffer_.size());
    buffer_.clear();
}

// A header whose length agrees with that of a cut segment is a strong sign, so the PDU needs no other.
void MbapStream::on_cut(const PacketRef& packet, std::size_t count, AduSink& sink) {
    const Bytes all(buffer_.data(), buffer_.size());
    const std::size_t last = aligned_ ? 0 : all.size();
    for (std::size_t begin = 0; begin <= last; ++begin) {
        const auto rest = all.subspan(begin);
        if (rest.size() <= kMbapHeaderBytes || !can_begin_header(rest) ||
            adu_length(rest) != rest.size() + count)
            continue;
        skip(begin);
        pass(packet, rest, sink);
        return begin_aligned();
    }
    on_gap();
}

/// The search begins with the bytes of buffer_.
void MbapStream::lose_alignment() {
    aligned_ = false;
    ++resynchronisations_;
}

void MbapStream::skip(std::size_t count) {
    skipped_ += count;
    if (!certain_ && messages_ == 0 && skipped_ > kMostForeign) foreign_ = true;
}

}  // namespace takt::capture
