// The token of a message is the sequence number of the first record of its portion, and its index in it: it
// is the same after a rewind, also where the record gets another place in the queue. The cursor moves when
// the last message of a portion is finished. A gap has the last index: where it replaces a record whose first
// messages are finished, it is behind them.
#include "takt/publish/journal_messages.hpp"

#include <algorithm>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/publish/sample_codec.hpp"

namespace takt::publish {
namespace {

constexpr unsigned kIndexBits = 16;

std::uint64_t token_of(std::uint64_t sequence, std::size_t index) {
    return (sequence << kIndexBits) + index + 1;
}

bool have_same_messages(const MessageLimits& a, const MessageLimits& b) {
    return a.packet == b.packet && (a.packet == kNoPacketLimit || a.version == b.version);
}

}  // namespace

std::optional<SourceMessage> JournalMessages::next(Instant now, const MessageLimits& limits) {
    if (!have_same_messages(limits, limits_)) change_limits(limits);
    for (;;) {
        while (next_ < composed_.size()) {
            const auto index = next_++;
            const auto token = portions_.back().first_token + index;
            if (token <= finished_token_) continue;  // acknowledged before a rewind
            highest_token_ = std::max(highest_token_, token);
            highest_returned_ = std::max(highest_returned_, portions_.back().records.back().sequence);
            return SourceMessage{.token = token,
                                 .repeated = index < repeated_,
                                 .message = std::move(composed_[index].message)};
        }
        if (!read_portion(now)) return std::nullopt;
    }
}

// Nothing is in flight when the limits change: the session has rewound what was.
void JournalMessages::change_limits(const MessageLimits& limits) {
    limits_ = limits;
    if (highest_token_ == 0) return;
    rewind();
    other_messages_token_ = highest_token_;
    finished_token_ = std::min(finished_token_, token_of(journal_.acknowledged(destination_) + 1, 0) - 1);
}

std::optional<JournalMessages::Entry> JournalMessages::take_entry() {
    if (pending_) return std::exchange(pending_, {});
    const auto entry = journal_.read(destination_);
    failure_.reset();
    if (!entry) failure_ = entry.error();
    if (!entry || !*entry) return std::nullopt;
    const auto& header = (*entry)->header;
    if ((*entry)->repeated && header.sequence > highest_record_) last_of_earlier_run_ = header.sequence;
    highest_record_ = std::max(highest_record_, header.sequence);
    Entry taken{.header = header, .gap = (*entry)->gap, .batch = {}};
    if (taken.gap) return taken;
    if (auto batch = decode_samples((*entry)->payload)) taken.batch = *std::move(batch);
    return taken;
}

bool JournalMessages::read_portion(Instant now) {
    auto entry = take_entry();
    if (!entry) return false;
    const auto header = entry->header;
    const auto gap = entry->gap;
    Portion portion{.records = {{header.sequence, gap ? 0 : header.samples}},
                    .first_token = token_of(header.sequence, gap ? MessageComposer::kMostMessages - 1 : 0)};
    composed_.clear();
    next_ = 0;
    if (entry->batch) {
        const auto records = join_records(*std::move(entry), portion);
        if (composer_.joins_records()) note_end(portion);
        const auto place = place_of(header, portion);
        repeated_ = place.repeated;
        composer_.compose(records, place, composed_);
    } else if (gap) {
        const auto place = place_of(header, portion);
        repeated_ = place.repeated;
        composer_.compose(*gap, place, composed_);
    } else {
        rejected_ += header.samples;
        drop(portion, header.samples, 0);
    }
    TAKT_ASSERT(composed_.size() <= (gap ? 1 : MessageComposer::kMostMessages));
    std::uint64_t gaps = 0;
    for (const auto& composed : composed_) {
        portion.samples.push_back(composed.samples);
        portion.too_large += composed.too_large;
        gaps += composed.too_large > 0 ? 1 : 0;
    }
    if (portion.too_large > 0) drop(portion, portion.too_large, gaps);
    portions_.push_back(std::move(portion));
    finish_portions(now, finished_token_);
    return true;
}

std::vector<RecordSamples> JournalMessages::join_records(Entry&& first, Portion& portion) {
    const auto header = first.header;
    std::vector<RecordSamples> records;
    records.push_back({*std::move(first.batch), header.samples_before + 1});
    std::size_t samples = records.back().batch.samples.size();
    while (composer_.joins_records()) {
        pending_ = take_entry();
        if (!pending_ || !may_join(portion, header, *pending_, samples)) break;
        portion.records.push_back({pending_->header.sequence, pending_->header.samples});
        records.push_back({*std::move(pending_->batch), pending_->header.samples_before + 1});
        samples += records.back().batch.samples.size();
        pending_.reset();
    }
    return records;
}

// A portion that was read before ends where it ended then.
bool JournalMessages::may_join(const Portion& portion, const store::RecordHeader& first, const Entry& next,
                               std::size_t samples) const {
    if (!next.batch || next.header.epoch != first.epoch) return false;
    if ((next.header.sequence <= last_of_earlier_run_) != (first.sequence <= last_of_earlier_run_))
        return false;
    const auto last = portion.records.back().sequence;
    const auto end = std::ranges::lower_bound(ends_, last);
    if (end != ends_.end()) return last < *end;
    return samples + next.batch->samples.size() <= kMostSamples;
}

// A portion without the records that the journal has lost since has other messages, before and behind them.
void JournalMessages::note_end(const Portion& portion) {
    const auto last = portion.records.back().sequence;
    const bool is_rest =
        portion.first_token > highest_token_ && portion.records.front().sequence <= highest_returned_;
    if (is_rest) other_messages_token_ = std::max(other_messages_token_, portion.first_token);
    while (!ends_.empty() && ends_.front() <= journal_.acknowledged(destination_)) ends_.pop_front();
    const auto end = std::ranges::lower_bound(ends_, last);
    if (end == ends_.end()) {
        ends_.push_back(last);
    } else if (*end != last) {
        ends_.insert(end, last);
        other_messages_token_ = std::max(other_messages_token_, highest_token_);
        finished_token_ = std::min(finished_token_, portion.first_token - 1);
    }
}

StreamPlace JournalMessages::place_of(const store::RecordHeader& header, const Portion& portion) const {
    StreamPlace place{.epoch = header.epoch,
                      .first = header.samples_before + 1,
                      .packet_limit = limits_.packet,
                      .version = limits_.version};
    if (header.sequence <= last_of_earlier_run_ || other_messages_token_ >= portion.first_token)
        place.repeated = MessageComposer::kMostMessages;
    else if (highest_token_ >= portion.first_token)
        place.repeated = static_cast<std::size_t>(highest_token_ - portion.first_token) + 1;
    return place;
}

// The records are in flight, and have that many samples together: this cannot fail.
void JournalMessages::drop(Portion& portion, std::uint64_t samples, std::uint64_t gaps) {
    for (auto& record : portion.records) {
        const auto dropped = std::min(samples, record.samples);
        if (dropped == 0) continue;
        static_cast<void>(journal_.reject(destination_, record.sequence, dropped, std::exchange(gaps, 0)));
        record.samples -= dropped;
        samples -= dropped;
    }
}

void JournalMessages::acknowledge(Instant now, std::uint64_t token) {
    TAKT_ASSERT(token > finished_token_);
    finished_token_ = token;
    finish_portions(now, token);
}

void JournalMessages::reject(Instant now, std::uint64_t token, MqttReason) {
    TAKT_ASSERT(!portions_.empty());
    auto& portion = portions_.front();
    const auto index = static_cast<std::size_t>(token - portion.first_token);
    TAKT_ASSERT(index < portion.samples.size());
    const auto samples = portion.samples[index];
    rejected_ += samples;
    drop(portion, samples, 0);
    acknowledge(now, token);
}

// A portion without messages has no token of its own, and ends with the one before it.
void JournalMessages::finish_portions(Instant now, std::uint64_t token) {
    while (!portions_.empty()) {
        const auto& portion = portions_.front();
        const bool has_messages = !portion.samples.empty();
        if (has_messages && portion.first_token + portion.samples.size() - 1 > token) return;
        static_cast<void>(journal_.acknowledge(now, destination_, portion.records.back().sequence));
        too_large_ += portion.too_large;
        portions_.pop_front();
        if (portions_.empty()) composed_.clear();
    }
}

void JournalMessages::rewind() {
    journal_.rewind(destination_);
    portions_.clear();
    pending_.reset();
    composed_.clear();
    next_ = 0;
}

}  // namespace takt::publish
