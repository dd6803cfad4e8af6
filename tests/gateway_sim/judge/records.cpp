// The formats are those of src/store/journal/journal_record.cpp and journal_cursor.cpp, read a second time
// without their code.
#include "records.hpp"

#include <array>
#include <string_view>

namespace takt::gatewaysim {
namespace {

constexpr std::uint32_t kRecordMagic = 0x314A'4B54;
constexpr std::uint32_t kCursorMagic = 0x3243'4B54;
constexpr std::size_t kHeader = 60;
constexpr std::size_t kCursor = 108;

std::uint64_t little(Bytes bytes, std::size_t offset, std::size_t size) {
    std::uint64_t number = 0;
    for (std::size_t i = size; i-- > 0;) number = number << 8U | bytes[offset + i];
    return number;
}

/// CRC-32C (Castagnoli), a nibble at a time.
std::uint32_t checksum(Bytes bytes) {
    static const auto kTable = [] {
        std::array<std::uint32_t, 256> table{};
        for (std::uint32_t i = 0; i < table.size(); ++i) {
            std::uint32_t value = i;
            for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? 0x82F63B78U : 0U);
            table[i] = value;
        }
        return table;
    }();
    std::uint32_t crc = 0xFFFF'FFFF;
    for (const auto byte : bytes) crc = (crc >> 8U) ^ kTable[(crc ^ byte) & 0xFFU];
    return ~crc;
}

std::uint64_t hash(Bytes bytes) {
    std::uint64_t state = bytes.size();
    for (const auto byte : bytes) state = (state ^ byte) * 0x100000001B3;
    return state;
}

std::optional<ReadRecord> record_at(Bytes bytes, std::size_t& length) {
    if (bytes.size() < kHeader + 4 || little(bytes, 0, 4) != kRecordMagic) return std::nullopt;
    length = little(bytes, 4, 4);
    if (length < kHeader + 4 || length > bytes.size()) return std::nullopt;
    if (little(bytes, length - 4, 4) != checksum(bytes.first(length - 4))) return std::nullopt;
    ReadRecord record;
    auto& facts = record.facts;
    facts.samples = little(bytes, 12, 8);
    facts.sequence = little(bytes, 20, 8);
    facts.samples_before = little(bytes, 28, 8);
    facts.wall_ns = static_cast<std::int64_t>(little(bytes, 36, 8));
    facts.epoch = little(bytes, 52, 8);
    record.payload = bytes.subspan(kHeader, length - kHeader - 4);
    facts.payload = hash(record.payload);
    if (little(bytes, 8, 2) == 2 && record.payload.size() == 48)
        facts.gap = GapFacts{static_cast<std::uint16_t>(little(record.payload, 0, 2)),
                             static_cast<std::int64_t>(little(record.payload, 32, 8)),
                             static_cast<std::int64_t>(little(record.payload, 40, 8))};
    return record;
}

}  // namespace

std::vector<ReadRecord> read_records(Bytes bytes) {
    std::vector<ReadRecord> records;
    for (std::size_t offset = 0; offset < bytes.size();) {
        std::size_t length = 1;
        auto record = record_at(bytes.subspan(offset), length);
        if (record) records.push_back(*record);
        offset += record ? length : 1;
    }
    return records;
}

std::optional<CursorFacts> read_cursor(Bytes bytes) {
    if (bytes.size() != kCursor || little(bytes, 0, 4) != kCursorMagic) return std::nullopt;
    if (little(bytes, kCursor - 4, 4) != checksum(bytes.first(kCursor - 4))) return std::nullopt;
    return CursorFacts{.counter = little(bytes, 8, 8),
                       .sequence = little(bytes, 16, 8),
                       .samples = little(bytes, 24, 8),
                       .delivered = little(bytes, 48, 8),
                       .dropped = little(bytes, 56, 8)};
}

std::string text(const RecordFacts& facts) {
    return "record " + std::to_string(facts.sequence) + " of epoch " + std::to_string(facts.epoch) +
           ", samples " + std::to_string(facts.samples_before + 1) + ".." + std::to_string(facts.end()) +
           (facts.gap ? ", gap " + cause_name(facts.gap->cause) : "");
}

std::string cause_name(std::uint16_t cause) {
    constexpr std::array<std::string_view, 9> kNames{"?",           "restart",   "buffer_full",
                                                     "disk_failed", "disk_full", "source_lost",
                                                     "quota",       "damaged",   "replaced"};
    return std::string(kNames[cause < kNames.size() ? cause : 0]);
}

}  // namespace takt::gatewaysim
