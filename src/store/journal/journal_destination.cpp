#include "journal/journal_destination.hpp"

#include <algorithm>

namespace takt::store {

Result<void> JournalDestination::load() {
    TAKT_TRY(found_, cursor_.load());
    if (found_ == JournalCursor::Found::state) state_ = cursor_.durable();
    return {};
}

Result<void> JournalDestination::start(const StreamPosition& end) {
    if (found_ != JournalCursor::Found::state) {
        const Segment* oldest = segments_->first();
        state_.position = oldest != nullptr ? *oldest->start : end;
    }
    if (found_ == JournalCursor::Found::nothing) {
        state_.handed_out = end.sequence;
        // Without a durable cursor the next start would begin with the oldest record again.
        TAKT_CHECK(save());
    }
    highest_read_ =
        found_ == JournalCursor::Found::state ? std::min(state_.handed_out, end.sequence) : end.sequence;
    rewind();
    return {};
}

Result<std::optional<JournalEntry>> JournalDestination::read(std::size_t max_in_flight) {
    if (in_flight_.size() >= max_in_flight) return std::nullopt;
    announce_reads();
    TAKT_TRY(auto entry, reader_.next());
    if (!entry) return entry;
    CursorState after = in_flight_.empty() ? state_ : in_flight_.back();
    const std::uint64_t samples = reader_.position().samples - after.position.samples;
    (entry->gap ? after.dropped : after.delivered) += samples;
    if (entry->gap && samples > 0) {
        ++after.gaps;
        losses_->add(after.position.samples, samples, entry->gap->cause);
    }
    after.position = reader_.position();
    in_flight_.push_back(after);
    entry->repeated = after.position.sequence <= highest_read_;
    highest_read_ = std::max(highest_read_, after.position.sequence);
    return entry;
}

Result<void> JournalDestination::acknowledge(std::uint64_t sequence) {
    const auto sequence_of = [](const CursorState& state) { return state.position.sequence; };
    const auto entry = std::ranges::lower_bound(in_flight_, sequence, {}, sequence_of);
    if (entry == in_flight_.end() || sequence_of(*entry) != sequence)
        return fail(Code::out_of_range, static_cast<std::int64_t>(sequence));
    state_ = *entry;
    in_flight_.erase(in_flight_.begin(), entry + 1);
    return {};
}

// Each state in flight counts all entries before it.
Result<void> JournalDestination::reject(std::uint64_t sequence, std::uint64_t samples, std::uint64_t gaps) {
    const auto sequence_of = [](const CursorState& state) { return state.position.sequence; };
    const auto entry = std::ranges::lower_bound(in_flight_, sequence, {}, sequence_of);
    if (entry == in_flight_.end() || sequence_of(*entry) != sequence)
        return fail(Code::out_of_range, static_cast<std::int64_t>(sequence));
    const auto& before = entry == in_flight_.begin() ? state_ : *(entry - 1);
    if (samples > entry->delivered - before.delivered)
        return fail(Code::out_of_range, static_cast<std::int64_t>(samples));
    std::for_each(entry, in_flight_.end(), [&](CursorState& state) {
        state.delivered -= samples;
        state.dropped += samples;
        state.gaps += gaps;
    });
    return {};
}

// One sync for many reads: from now on a start must take any record for read. Without the sync an entry
// would be read all the same, and its mark could be missing after a crash.
void JournalDestination::announce_reads() {
    if (state_.handed_out == CursorState::kAllHandedOut) return;
    state_.handed_out = CursorState::kAllHandedOut;
    static_cast<void>(save());
}

bool JournalDestination::needs_quota_end() const {
    const CursorState& durable = cursor_.durable();
    return segments_->quota_end.sequence > std::max(durable.position.sequence, durable.quota_end.sequence);
}

Result<void> JournalDestination::save() {
    state_.quota_end = segments_->quota_end;
    return cursor_.save(state_);
}

void JournalDestination::withdraw_announcement() {
    state_.handed_out = std::max(highest_read_, state_.position.sequence);
}

void JournalDestination::rewind() {
    withdraw_announcement();
    in_flight_.clear();
    reader_ = JournalReader(*segments_, *storage_, state_.position);
}

// Gaps among the samples that are read again count as delivered before, as far as there are any.
void JournalDestination::go_back(const StreamPosition& position) {
    const std::uint64_t samples = state_.position.samples - position.samples;
    const std::uint64_t delivered = std::min(samples, state_.delivered);
    state_.delivered -= delivered;
    state_.dropped -= samples - delivered;
    state_.position = position;
    rewind();
}

std::optional<std::int64_t> JournalDestination::oldest_waiting_ns() {
    for (const CursorState& entry : in_flight_)
        if (entry.delivered > state_.delivered) return entry.position.wall_ns;
    const std::uint64_t cursor = state_.position.sequence;
    const Segment* const first = segments_->first();
    if (first == nullptr || reader_.position().sequence >= segments_->durable.sequence) return std::nullopt;
    if (oldest_ && oldest_->cursor == cursor && oldest_->first_segment == first->number)
        return oldest_->wall_ns;
    oldest_.reset();
    if (const auto found = find_oldest()) oldest_ = FoundOldest{cursor, first->number, *found};
    return oldest_ ? std::optional(oldest_->wall_ns) : std::nullopt;
}

// The copy continues where the reader is: only after a rewind it searches the segment.
std::optional<std::int64_t> JournalDestination::find_oldest() const {
    JournalReader reader = reader_;
    for (auto entry = reader.next(); entry && *entry; entry = reader.next())
        if (!(*entry)->gap && (*entry)->header.samples > 0) return (*entry)->header.wall_ns;
    return std::nullopt;
}

// A record in flight waits until it is acknowledged, also if the quota has removed it. A gap is dropped as
// soon as it is known.
DestinationCounters JournalDestination::counters(std::uint64_t samples, std::uint64_t open) const {
    const CursorState& read = in_flight_.empty() ? state_ : in_flight_.back();
    const auto unread = losses_->after(read.position.samples);
    DestinationCounters counters;
    counters.appended = state_.delivered + state_.dropped + samples - state_.position.samples;
    counters.delivered = state_.delivered;
    counters.dropped = read.dropped + unread.samples + open;
    counters.waiting = counters.appended - counters.delivered - counters.dropped;
    counters.gaps = read.gaps + unread.gaps + (open > 0 ? 1 : 0);
    return counters;
}

}  // namespace takt::store
