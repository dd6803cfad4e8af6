// pcapng: sections of blocks (draft-ietf-opsawg-pcapng). A section header sets the byte order and begins the
// numbering of interfaces anew. Blocks of unknown types are skipped.
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/record_parser.hpp"
#include "takt/capture/pcapng_format.hpp"

namespace takt::capture {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr std::uint16_t kPcapngVersion = 1;
constexpr std::size_t kBlockHead = 8;
constexpr std::size_t kLeastSection = 28;
constexpr std::size_t kLeastInterface = 20;
constexpr std::size_t kPacketHead = 28;            // of an enhanced packet block, with the block's head
constexpr std::size_t kStatisticsHead = 20;        // likewise of an interface statistics block
constexpr std::size_t kSimpleHead = 12;            // likewise of a simple packet block
constexpr std::size_t kMostDescription = 1 << 16;  // bytes of a section header or an interface description
// A packet and its options.
constexpr std::size_t kMostBlock = format::kMostPacket + kMostDescription;
constexpr std::uint8_t kMostDecimal = 19;
constexpr std::uint8_t kMostBinary = 63;

constexpr std::int64_t kSecond = 1'000'000'000;

std::int64_t clamped(Wide value) {
    return value > static_cast<Wide>(INT64_MAX) ? INT64_MAX : static_cast<std::int64_t>(value);
}

/// Ticks of an interface to nanoseconds.
struct Resolution {
    std::uint64_t multiplier = 1000;
    std::uint64_t divisor = 1;
    std::uint8_t shift = 0;                       // then divided by 2^shift
    std::uint64_t most_exact = INT64_MAX / 1000;  // ticks up to here need the multiplier only

    [[nodiscard]] std::int64_t nanoseconds(std::uint64_t ticks) const {
        // The usual case without a division of 128 bits.
        if (ticks <= most_exact) return static_cast<std::int64_t>(ticks * multiplier);
        return clamped(static_cast<Wide>(ticks) * multiplier / divisor >> shift);
    }
};

std::uint64_t power_of_ten(unsigned exponent) {
    std::uint64_t power = 1;
    while (exponent-- > 0) power *= 10;
    return power;
}

struct Interface {
    LinkType link{};
    std::uint32_t most_captured = 0;  // snaplen; 0: no limit
    Resolution resolution;
    std::int64_t offset_ns = 0;
    std::string name;
    std::uint32_t number = 0;   // over all sections
    std::uint64_t dropped = 0;  // by the last statistics
};

/// The options of a block, one after the other.
class Options {
public:
    Options(Bytes bytes, Numbers numbers) : rest_(bytes), numbers_(numbers) {}

    /// @returns false: there is no further one
    bool next() {
        if (rest_.size() < 4) return false;
        code = numbers_.u16(rest_.data());
        const std::size_t length = numbers_.u16(rest_.data() + 2);
        if (code == format::kEndOfOptions || rest_.size() < 4 + length) return false;
        value = rest_.subspan(4, length);
        rest_ = rest_.subspan(std::min(rest_.size(), 4 + (length + 3) / 4 * 4));
        return true;
    }
    [[nodiscard]] std::string_view text() const {
        return {reinterpret_cast<const char*>(value.data()), value.size()};
    }

    std::uint16_t code = 0;
    Bytes value;

private:
    Bytes rest_;
    Numbers numbers_;
};

class PcapngParser final : public RecordParser {
public:
    RecordStep read(Bytes bytes) override {
        if (bytes.size() < format::kBlockFrame) return need(format::kBlockFrame);
        if (Numbers().u32(bytes.data()) == format::kSectionHeader) return read_section(bytes);
        const auto type = numbers_.u32(bytes.data());
        const std::size_t length = numbers_.u32(bytes.data() + 4);
        if (length < format::kBlockFrame || length % 4 != 0)
            return fault(CaptureFault::record_too_short, length, format::kBlockFrame);
        switch (type) {
            case format::kInterface: return with_block(bytes, length, kLeastInterface, kMostDescription);
            case format::kEnhancedPacket:
            case format::kObsoletePacket: return with_block(bytes, length, kPacketHead + 4, kMostBlock);
            case format::kSimplePacket: return with_block(bytes, length, kSimpleHead + 4, kMostBlock);
            case format::kInterfaceStatistics:
                return with_block(bytes, length, kStatisticsHead + 4, kMostDescription);
            default: return {.length = length};
        }
    }

private:
    RecordStep read_section(Bytes bytes) {
        const auto magic = Numbers().u32(bytes.data() + kBlockHead);
        const bool swapped = magic == std::byteswap(format::kByteOrderMagic);
        if (!swapped && magic != format::kByteOrderMagic) return fault(CaptureFault::byte_order, magic);
        numbers_ = Numbers(swapped);
        const std::size_t length = numbers_.u32(bytes.data() + 4);
        return with_block(bytes, length, kLeastSection, kMostDescription);
    }

    /// Reads a block as soon as it is complete.
    RecordStep with_block(Bytes bytes, std::size_t length, std::size_t least, std::size_t most) {
        if (length < least) return fault(CaptureFault::record_too_short, length, least);
        if (length > most) return fault(CaptureFault::record_length, length, most);
        if (bytes.size() < length) return need(length);
        const Bytes block = bytes.first(length);
        const std::size_t again = numbers_.u32(block.data() + length - 4);
        if (again != length) return fault(CaptureFault::length_differs, again, length);
        if (Numbers().u32(block.data()) == format::kSectionHeader) return begin_section(block);
        switch (numbers_.u32(block.data())) {
            case format::kInterface: return add_interface(block);
            case format::kSimplePacket: return simple_packet(block);
            case format::kInterfaceStatistics: return statistics(block);
            case format::kObsoletePacket: return packet(block, numbers_.u16(block.data() + kBlockHead));
            default: return packet(block, numbers_.u32(block.data() + kBlockHead));
        }
    }

    RecordStep begin_section(Bytes block) {
        const auto version = numbers_.u16(block.data() + 12);
        if (version != kPcapngVersion) return fault(CaptureFault::version, version, kPcapngVersion);
        interfaces_.clear();
        return {.length = block.size()};
    }

    RecordStep add_interface(Bytes block) {
        Interface interface{.link = static_cast<LinkType>(numbers_.u16(block.data() + 8)),
                            .most_captured = numbers_.u32(block.data() + 12)};
        if (interfaces_.size() >= kMostInterfaces)
            return fault(CaptureFault::interface, interfaces_.size(), kMostInterfaces);
        for (Options options(block.subspan(16, block.size() - 20), numbers_); options.next();) {
            const auto value = options.value;
            if (options.code == format::kInterfaceName)
                interface.name = options.text().substr(0, format::kMostInterfaceName);
            if (options.code == format::kTimeResolution && value.size() == 1 &&
                !set_resolution(interface, value[0]))
                return fault(CaptureFault::resolution, value[0] & 0x7FU,
                             value[0] & format::kPowerOfTwo ? kMostBinary : kMostDecimal);
            if (options.code == format::kTimeOffset && value.size() == 8)
                interface.offset_ns = offset_ns(static_cast<std::int64_t>(numbers_.u64(value.data())));
        }
        interface.number = next_number_++;
        interfaces_.push_back(std::move(interface));
        return {.length = block.size()};
    }

    RecordStep statistics(Bytes block) {
        RecordStep step{.length = block.size()};
        const auto number = numbers_.u32(block.data() + kBlockHead);
        if (number >= interfaces_.size()) return step;
        auto& interface = interfaces_[number];
        Options options(block.subspan(kStatisticsHead, block.size() - kStatisticsHead - 4), numbers_);
        while (options.next()) {
            if (options.code != format::kDropped || options.value.size() != 8) continue;
            const auto dropped = numbers_.u64(options.value.data());
            step.dropped = dropped - std::min(dropped, interface.dropped);
            interface.dropped = dropped;
        }
        return step;
    }

    static bool set_resolution(Interface& interface, std::uint8_t value) {
        const std::uint8_t exponent = value & 0x7FU;
        auto& resolution = interface.resolution;
        if (value & format::kPowerOfTwo) {
            if (exponent > kMostBinary) return false;
            resolution = {static_cast<std::uint64_t>(kSecond), 1, exponent, 0};
        } else {
            if (exponent > kMostDecimal) return false;
            const auto factor = power_of_ten(exponent <= 9 ? 9U - exponent : exponent - 9U);
            resolution =
                exponent <= 9 ? Resolution{factor, 1, 0, INT64_MAX / factor} : Resolution{1, factor, 0, 0};
        }
        return true;
    }

    static std::int64_t offset_ns(std::int64_t seconds) {
        constexpr std::int64_t kMost = INT64_MAX / kSecond / 2;
        return std::clamp(seconds, -kMost, kMost) * kSecond;
    }

    RecordStep packet(Bytes block, std::uint32_t number) const {
        if (number >= interfaces_.size()) return fault(CaptureFault::interface, number, interfaces_.size());
        const auto& interface = interfaces_[number];
        const std::uint8_t* const at = block.data();
        const std::size_t captured = numbers_.u32(at + 20);
        if (captured > block.size() - kPacketHead - 4)
            return fault(CaptureFault::record_length, captured, block.size() - kPacketHead - 4);
        const auto ticks = std::uint64_t{numbers_.u32(at + 12)} << 32 | numbers_.u32(at + 16);
        auto step = step_of(block, interface);
        set_time(step.packet, interface.resolution.nanoseconds(ticks), interface.offset_ns);
        step.packet.original_length = std::max(numbers_.u32(at + 24), static_cast<std::uint32_t>(captured));
        step.packet.data = block.subspan(kPacketHead, captured);
        const auto end_of_data = kPacketHead + (captured + 3) / 4 * 4;
        if (end_of_data < block.size() - 4)
            step.packet.comment = comment_in(block.subspan(end_of_data, block.size() - 4 - end_of_data));
        return step;
    }

    static void set_time(Packet& packet, std::int64_t since_offset_ns, std::int64_t offset_ns) {
        const auto time_ns = std::min(since_offset_ns, kMostTime) + offset_ns;
        packet.timed = since_offset_ns <= kMostTime && time_ns >= 0 && time_ns <= kMostTime;
        packet.time_ns = packet.timed ? time_ns : 0;
    }

    [[nodiscard]] std::string_view comment_in(Bytes bytes) const {
        for (Options options(bytes, numbers_); options.next();)
            if (options.code == format::kComment) return options.text();
        return {};
    }

    /// It belongs to the first interface. Its captured length follows from the original one and the snaplen.
    RecordStep simple_packet(Bytes block) const {
        if (interfaces_.empty()) return fault(CaptureFault::interface, 0, 0);
        const auto& interface = interfaces_.front();
        const std::uint32_t original = numbers_.u32(block.data() + kBlockHead);
        std::size_t captured = std::min<std::size_t>(original, block.size() - kSimpleHead - 4);
        if (interface.most_captured > 0) captured = std::min<std::size_t>(captured, interface.most_captured);
        auto step = step_of(block, interface);
        step.packet.timed = false;
        step.packet.original_length = std::max(original, static_cast<std::uint32_t>(captured));
        step.packet.data = block.subspan(kSimpleHead, captured);
        return step;
    }

    static RecordStep step_of(Bytes block, const Interface& interface) {
        RecordStep step{.length = block.size(), .has_packet = true};
        step.packet.link = interface.link;
        step.packet.interface = interface.number;
        step.packet.interface_name = interface.name;
        return step;
    }

    static constexpr std::size_t kMostInterfaces = 65536;

    Numbers numbers_;
    std::vector<Interface> interfaces_;  // of this section
    std::uint32_t next_number_ = 0;
};

}  // namespace

std::unique_ptr<RecordParser> make_pcapng_parser() {
    return std::make_unique<PcapngParser>();
}

}  // namespace takt::capture
