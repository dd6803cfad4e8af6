#include "takt/capture/capture_reader.hpp"

#include <algorithm>
#include <cstring>

#include "files/record_parser.hpp"
#include "takt/capture/pcapng_format.hpp"

namespace takt::capture {
namespace {

constexpr std::size_t kSpace = 512 << 10;
constexpr std::size_t kMagic = 4;

std::uint32_t first_bytes(Bytes bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < kMagic; ++i) value = value << 8 | (i < bytes.size() ? bytes[i] : 0U);
    return value;
}

bool is_compressed(std::uint32_t magic) {
    return magic >> 16 == 0x1F8B || magic == 0x28B52FFD || magic == 0x04224D18 || magic == 0xFD377A58;
}

}  // namespace

std::string_view name(CaptureFault fault) {
    switch (fault) {
        case CaptureFault::empty: return "empty";
        case CaptureFault::not_a_capture: return "not_a_capture";
        case CaptureFault::compressed: return "compressed";
        case CaptureFault::version: return "version";
        case CaptureFault::byte_order: return "byte_order";
        case CaptureFault::record_length: return "record_length";
        case CaptureFault::record_too_short: return "record_too_short";
        case CaptureFault::length_differs: return "length_differs";
        case CaptureFault::interface: return "interface";
        case CaptureFault::resolution: return "resolution";
        case CaptureFault::incomplete: return "incomplete";
    }
    return "unknown";
}

std::unique_ptr<RecordParser> make_parser(Bytes beginning) {
    if (Numbers().u32(beginning.data()) == format::kSectionHeader) return make_pcapng_parser();
    return make_pcap_parser(beginning.first(kMagic));
}

CaptureReader::CaptureReader(PacketSink& sink) : sink_(sink), buffer_(2 * kSpace) {}

CaptureReader::~CaptureReader() = default;

std::span<std::uint8_t> CaptureReader::space() {
    if (buffer_.size() - end_ < kSpace && begin_ > 0) {
        std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
        end_ -= begin_;
        begin_ = 0;
    }
    return std::span(buffer_).subspan(end_);
}

bool CaptureReader::filled(std::size_t count) {
    end_ += count;
    if (error_) return false;
    if (!parser_ && !begin()) return !error_;
    return parse();
}

void CaptureReader::end() {
    if (error_) return;
    const std::size_t there = end_ - begin_;
    if (!parser_ && there == 0) {
        stop(CaptureFault::empty, 0);
    } else if (!parser_) {
        stop(CaptureFault::not_a_capture, first_bytes(std::span(buffer_).subspan(begin_, there)));
    } else if (there > 0) {
        const auto step = parser_->read(std::span(buffer_).subspan(begin_, there));
        stop(CaptureFault::incomplete, there, step.needed);
    } else if (skip_ > 0) {
        stop(CaptureFault::incomplete, 0, skip_);
    }
}

bool CaptureReader::begin() {
    const Bytes bytes = std::span(buffer_).subspan(begin_, end_ - begin_);
    if (bytes.size() < kMagic) return false;
    parser_ = make_parser(bytes);
    if (parser_) return true;
    const auto magic = first_bytes(bytes);
    return stop(is_compressed(magic) ? CaptureFault::compressed : CaptureFault::not_a_capture, magic);
}

bool CaptureReader::stop(CaptureFault fault, std::uint64_t value, std::uint64_t allowed) {
    error_ = CaptureError{fault, offset_, packets_, value, allowed};
    return false;
}

/// @returns whether all bytes to skip have come
bool CaptureReader::skip() {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(skip_, end_ - begin_));
    skip_ -= count;
    begin_ += count;
    offset_ += count;
    return skip_ == 0;
}

bool CaptureReader::parse() {
    while (skip()) {
        const Bytes bytes = std::span(buffer_).subspan(begin_, end_ - begin_);
        if (bytes.empty()) break;
        auto step = parser_->read(bytes);
        if (step.error) return stop(step.error->fault, step.error->value, step.error->allowed);
        if (step.needed > 0) break;
        if (step.has_packet) {
            step.packet.number = ++packets_;
            sink_.on_packet(step.packet);
        }
        dropped_ += step.dropped;
        skip_ = step.length;
    }
    return true;
}

}  // namespace takt::capture
