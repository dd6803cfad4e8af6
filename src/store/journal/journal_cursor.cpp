// A slot, little endian, without padding:
//   magic u32 | handed out u32 | counter u64 | sequence u64 | samples u64 | wall time i64 | epoch u64 |
//   delivered u64 | dropped u64 | gaps u64 | end of what the quota removed: sequence u64, samples u64,
//   wall time i64, epoch u64 | CRC-32C u32 (all before it)
// "Handed out" is the number of records behind the sequence number that may have been read; 2^32 - 1: all.
#include "journal/journal_cursor.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "journal/little_endian.hpp"
#include "takt/base/assert.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {
namespace {

constexpr std::uint32_t kCursorMagic = 0x3243'4B54;  // "TKC2"
constexpr std::size_t kSlotBytes = 108;
constexpr std::uint32_t kAll = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kCheckedBytes = kSlotBytes - 4;

struct Slot {
    std::uint64_t counter = 0;
    CursorState state;
};

std::vector<std::uint8_t> encode(const Slot& slot) {
    std::vector<std::uint8_t> out;
    const std::uint64_t sequence = slot.state.position.sequence;
    const std::uint64_t ahead = std::max(slot.state.handed_out, sequence) - sequence;
    put_little(out, kCursorMagic);
    put_little(out, static_cast<std::uint32_t>(std::min<std::uint64_t>(ahead, kAll)));
    put_little(out, slot.counter);
    put_position(out, slot.state.position);
    put_little(out, slot.state.delivered);
    put_little(out, slot.state.dropped);
    put_little(out, slot.state.gaps);
    put_position(out, slot.state.quota_end);
    put_little(out, crc32c(out));
    TAKT_ASSERT(out.size() == kSlotBytes);
    return out;
}

std::optional<Slot> decode(Bytes bytes) {
    if (bytes.size() != kSlotBytes) return std::nullopt;
    const auto crc = LittleEndianReader(bytes.subspan(kCheckedBytes)).take<std::uint32_t>();
    if (crc != crc32c(bytes.first(kCheckedBytes))) return std::nullopt;
    LittleEndianReader in(bytes);
    if (in.take<std::uint32_t>() != kCursorMagic) return std::nullopt;
    const auto ahead = in.take<std::uint32_t>();
    Slot slot;
    slot.counter = in.take<std::uint64_t>();
    slot.state.position = take_position(in);
    slot.state.delivered = in.take<std::uint64_t>();
    slot.state.dropped = in.take<std::uint64_t>();
    slot.state.gaps = in.take<std::uint64_t>();
    slot.state.quota_end = take_position(in);
    slot.state.handed_out = ahead == kAll ? CursorState::kAllHandedOut : slot.state.position.sequence + ahead;
    return slot;
}

}  // namespace

Result<JournalCursor::Found> JournalCursor::load() {
    // An earlier run may have ended before its sync. A slot that may still be lost must not be the only good
    // one when the other is overwritten.
    if (const auto synced = storage_->sync_cursor(name_); !synced) {
        if (synced.error().code == Code::not_found) return Found::nothing;
        return std::unexpected(synced.error());
    }
    Found found = Found::damaged;
    for (unsigned i = 0; i < 2; ++i) {
        std::array<std::uint8_t, kSlotBytes> bytes{};
        TAKT_TRY(const std::size_t size, storage_->read_cursor(name_, i, bytes));
        const auto slot = decode(Bytes(bytes).first(size));
        if (!slot || (found == Found::state && slot->counter < counter_)) continue;
        found = Found::state;
        counter_ = slot->counter;
        durable_ = slot->state;
        next_slot_ = 1 - i;
    }
    return found;
}

Result<void> JournalCursor::save(const CursorState& state) {
    TAKT_CHECK(storage_->write_cursor(name_, next_slot_, encode({counter_ + 1, state})));
    TAKT_CHECK(storage_->sync_cursor(name_));
    ++counter_;
    next_slot_ = 1 - next_slot_;
    durable_ = state;
    return {};
}

}  // namespace takt::store
