// A record, little endian, without padding:
//   magic u32 | length u32 (all of the record) | type u16 | reserved u16 | samples u64 | sequence u64 |
//   samples before u64 | wall time i64 | monotonic time i64 | epoch u64 | payload | CRC-32C u32 (all before
//   it)
#include "takt/store/journal_record.hpp"

#include "journal/little_endian.hpp"
#include "takt/base/assert.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {
namespace {

constexpr std::uint32_t kRecordMagic = 0x314A'4B54;  // "TKJ1"
constexpr std::size_t kLengthOffset = 4;
constexpr std::size_t kTypeOffset = 8;
constexpr std::size_t kChecksumBytes = kRecordOverheadBytes - kRecordHeaderBytes;

bool is_type(RecordType type) {
    return type == RecordType::samples || type == RecordType::gap;
}

bool is_cause(std::uint16_t cause) {
    return cause >= static_cast<std::uint16_t>(GapCause::restart) &&
           cause <= static_cast<std::uint16_t>(GapCause::replaced);
}

}  // namespace

std::string_view name(GapCause cause) {
    switch (cause) {
        case GapCause::restart: return "restart";
        case GapCause::buffer_full: return "buffer_full";
        case GapCause::disk_failed: return "disk_failed";
        case GapCause::disk_full: return "disk_full";
        case GapCause::source_lost: return "source_lost";
        case GapCause::quota: return "quota";
        case GapCause::damaged: return "damaged";
        case GapCause::replaced: return "replaced";
    }
    return "";
}

void encode_record(const RecordHeader& header, Bytes payload, std::vector<std::uint8_t>& out) {
    TAKT_ASSERT(payload.size() <= kMaxPayloadBytes);
    const std::size_t start = out.size();
    put_little(out, kRecordMagic);
    put_little(out, static_cast<std::uint32_t>(kRecordOverheadBytes + payload.size()));
    put_little(out, static_cast<std::uint16_t>(header.type));
    put_little(out, std::uint16_t{0});
    put_little(out, header.samples);
    put_little(out, header.sequence);
    put_little(out, header.samples_before);
    put_little(out, static_cast<std::uint64_t>(header.wall_ns));
    put_little(out, static_cast<std::uint64_t>(header.monotonic_ns));
    put_little(out, header.epoch);
    out.insert(out.end(), payload.begin(), payload.end());
    put_little(out, crc32c(Bytes(out).subspan(start)));
}

bool begins_record(Bytes bytes) {
    return bytes.size() < sizeof kRecordMagic ||
           LittleEndianReader(bytes).take<std::uint32_t>() == kRecordMagic;
}

std::size_t encoded_size(Bytes record) {
    return LittleEndianReader(record.subspan(kLengthOffset)).take<std::uint32_t>();
}

RecordHeader encoded_header(Bytes record) {
    LittleEndianReader in(record.subspan(kTypeOffset));
    RecordHeader header;
    header.type = static_cast<RecordType>(in.take<std::uint16_t>());
    static_cast<void>(in.take<std::uint16_t>());
    header.samples = in.take<std::uint64_t>();
    header.sequence = in.take<std::uint64_t>();
    header.samples_before = in.take<std::uint64_t>();
    header.wall_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    header.monotonic_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    header.epoch = in.take<std::uint64_t>();
    return header;
}

DecodedRecord decode_record(Bytes bytes) {
    DecodedRecord record;
    if (!begins_record(bytes)) return record;
    record.state = DecodeState::torn;
    if (bytes.size() < kRecordHeaderBytes) return record;
    const std::size_t length = encoded_size(bytes);
    const bool possible = length >= kRecordOverheadBytes && length <= kMaxRecordBytes;
    if (possible && bytes.size() < length) return record;
    record.state = DecodeState::damaged;
    if (!possible) return record;
    const Bytes checked = bytes.first(length - kChecksumBytes);
    if (LittleEndianReader(bytes.subspan(checked.size())).take<std::uint32_t>() != crc32c(checked))
        return record;
    record.header = encoded_header(bytes);
    if (!is_type(record.header.type)) return record;
    record.state = DecodeState::good;
    record.payload = checked.subspan(kRecordHeaderBytes);
    record.bytes = length;
    return record;
}

void encode_gap(const Gap& gap, std::vector<std::uint8_t>& out) {
    put_little(out, static_cast<std::uint16_t>(gap.cause));
    put_little(out, std::uint16_t{0});
    put_little(out, std::uint32_t{0});
    put_little(out, gap.samples);
    put_little(out, gap.first_sequence);
    put_little(out, gap.last_sequence);
    put_little(out, static_cast<std::uint64_t>(gap.first_wall_ns));
    put_little(out, static_cast<std::uint64_t>(gap.last_wall_ns));
}

Result<Gap> decode_gap(Bytes payload) {
    if (payload.size() != kGapPayloadBytes) return fail(Code::malformed);
    LittleEndianReader in(payload);
    const auto cause = in.take<std::uint16_t>();
    if (!is_cause(cause)) return fail(Code::malformed);
    static_cast<void>(in.take<std::uint16_t>());
    static_cast<void>(in.take<std::uint32_t>());
    Gap gap;
    gap.cause = static_cast<GapCause>(cause);
    gap.samples = in.take<std::uint64_t>();
    gap.first_sequence = in.take<std::uint64_t>();
    gap.last_sequence = in.take<std::uint64_t>();
    gap.first_wall_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    gap.last_wall_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    return gap;
}

}  // namespace takt::store
