// A slot, little endian, without padding:
//   magic u32 | cause u32 | counter u64 | last durable record: sequence u64, samples u64, wall time i64,
//   epoch u64 | samples u64 | wall times of what is not durable: first i64, last i64 | CRC-32C u32 (all
//   before it)
#include "journal/journal_end.hpp"

#include <array>
#include <vector>

#include "journal/little_endian.hpp"
#include "takt/base/assert.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {
namespace {

constexpr std::uint32_t kEndMagic = 0x3145'4B54;  // "TKE1"
constexpr std::size_t kEndChecked = 72;
constexpr std::size_t kEndBytes = kEndChecked + 4;

struct EndSlot {
    std::uint64_t counter = 0;
    JournalEnd end;
};

std::vector<std::uint8_t> encode_end(const EndSlot& slot) {
    std::vector<std::uint8_t> out;
    put_little(out, kEndMagic);
    put_little(out, static_cast<std::uint32_t>(slot.end.cause));
    put_little(out, slot.counter);
    put_position(out, slot.end.durable);
    put_little(out, slot.end.samples);
    put_little(out, static_cast<std::uint64_t>(slot.end.first_wall_ns));
    put_little(out, static_cast<std::uint64_t>(slot.end.last_wall_ns));
    TAKT_ASSERT(out.size() == kEndChecked);
    put_little(out, crc32c(out));
    return out;
}

std::optional<EndSlot> decode_end(Bytes bytes) {
    if (bytes.size() != kEndBytes) return std::nullopt;
    const auto crc = LittleEndianReader(bytes.subspan(kEndChecked)).take<std::uint32_t>();
    if (crc != crc32c(bytes.first(kEndChecked))) return std::nullopt;
    LittleEndianReader in(bytes);
    if (in.take<std::uint32_t>() != kEndMagic) return std::nullopt;
    EndSlot slot;
    slot.end.cause = static_cast<GapCause>(in.take<std::uint32_t>());
    slot.counter = in.take<std::uint64_t>();
    slot.end.durable = take_position(in);
    slot.end.samples = in.take<std::uint64_t>();
    slot.end.first_wall_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    slot.end.last_wall_ns = static_cast<std::int64_t>(in.take<std::uint64_t>());
    return slot;
}

}  // namespace

Result<std::optional<JournalEnd>> JournalEndFile::load() {
    for (unsigned i = 0; i < 2; ++i) {
        std::array<std::uint8_t, kEndBytes> bytes{};
        TAKT_TRY(const std::size_t size, storage_->read_end(i, bytes));
        const auto slot = decode_end(Bytes(bytes).first(size));
        if (!slot || slot->counter <= counter_) continue;
        counter_ = slot->counter;
        written_ = slot->end;
    }
    return written_;
}

Result<void> JournalEndFile::write(const JournalEnd& end) {
    if (written_ == end) return {};
    const int slots = written_ ? 1 : 2;
    for (int i = 0; i < slots; ++i) {
        ++counter_;
        TAKT_CHECK(storage_->write_end(static_cast<unsigned>(counter_ % 2), encode_end({counter_, end})));
    }
    written_ = end;
    return {};
}

}  // namespace takt::store
