// pcap: a file header of 24 bytes, then records of a header of 16 bytes and the captured bytes
// (draft-ietf-opsawg-pcap).
#include <algorithm>

#include "files/record_parser.hpp"
#include "takt/capture/pcapng_format.hpp"

namespace takt::capture {
namespace {

constexpr std::uint16_t kPcapVersion = 2;

class PcapParser final : public RecordParser {
public:
    PcapParser(bool swapped, bool nanoseconds) : numbers_(swapped), unit_ns_(nanoseconds ? 1 : 1000) {}

    RecordStep read(Bytes bytes) override { return begun_ ? read_packet(bytes) : read_header(bytes); }

private:
    RecordStep read_header(Bytes bytes) {
        if (bytes.size() < format::kPcapHeader) return need(format::kPcapHeader);
        const auto version = numbers_.u16(bytes.data() + 4);
        if (version != kPcapVersion) return fault(CaptureFault::version, version, kPcapVersion);
        // The upper bits of the field hold the length of frame check sequences.
        link_ = static_cast<LinkType>(numbers_.u32(bytes.data() + 20) & 0xFFFF);
        begun_ = true;
        return {.length = format::kPcapHeader};
    }

    RecordStep read_packet(Bytes bytes) const {
        if (bytes.size() < format::kPcapRecord) return need(format::kPcapRecord);
        const std::uint8_t* const at = bytes.data();
        const std::size_t captured = numbers_.u32(at + 8);
        if (captured > format::kMostPacket)
            return fault(CaptureFault::record_length, captured, format::kMostPacket);
        const std::size_t length = format::kPcapRecord + captured;
        if (bytes.size() < length) return need(length);
        RecordStep step{.length = length, .has_packet = true};
        step.packet.time_ns =
            numbers_.u32(at) * std::int64_t{1'000'000'000} + numbers_.u32(at + 4) * unit_ns_;
        step.packet.link = link_;
        step.packet.original_length = std::max(numbers_.u32(at + 12), static_cast<std::uint32_t>(captured));
        step.packet.data = bytes.subspan(format::kPcapRecord, captured);
        return step;
    }

    Numbers numbers_;
    std::int64_t unit_ns_;
    LinkType link_{};
    bool begun_ = false;
};

}  // namespace

std::unique_ptr<RecordParser> make_pcap_parser(Bytes magic) {
    for (const bool swapped : {false, true}) {
        const auto value = Numbers(swapped).u32(magic.data());
        if (value == format::kMicrosecondMagic || value == format::kNanosecondMagic)
            return std::make_unique<PcapParser>(swapped, value == format::kNanosecondMagic);
    }
    return nullptr;
}

}  // namespace takt::capture
