// The token of a message is the sequence number of its record and its index in it: it is the same after a
// rewind, also where the record gets another place in the queue. A record has its cursor moved when its last
// message is finished. A gap has the last index: where it replaces a record whose first messages are
// finished, it is behind them.
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
            const auto token = records_.back().first_token + next_;
            auto& message = composed_[next_++].message;
            if (token <= finished_token_) continue;  // acknowledged before a rewind
            const bool repeated = token <= highest_token_ || records_.back().sequence <= last_of_earlier_run_;
            highest_token_ = std::max(highest_token_, token);
            return SourceMessage{.token = token, .repeated = repeated, .message = std::move(message)};
        }
        if (!read_record(now)) return std::nullopt;
    }
}

// Nothing is in flight when the limits change: the session has rewound what was.
void JournalMessages::change_limits(const MessageLimits& limits) {
    limits_ = limits;
    if (highest_token_ == 0) return;
    rewind();
    other_limits_token_ = highest_token_;
    finished_token_ = std::min(finished_token_, token_of(journal_.acknowledged(destination_) + 1, 0) - 1);
}

bool JournalMessages::read_record(Instant now) {
    const auto entry = journal_.read(destination_);
    failure_.reset();
    if (!entry) failure_ = entry.error();
    if (!entry || !*entry) return false;
    const auto& header = (*entry)->header;
    if ((*entry)->repeated && header.sequence > highest_record_) last_of_earlier_run_ = header.sequence;
    highest_record_ = std::max(highest_record_, header.sequence);
    const bool is_gap = (*entry)->gap.has_value();
    const auto first_token = token_of(header.sequence, is_gap ? MessageComposer::kMostMessages - 1 : 0);
    const bool readable = compose(**entry, place_of(header, first_token));
    TAKT_ASSERT(composed_.size() <= (is_gap ? 1 : MessageComposer::kMostMessages));

    Record record{
        .sequence = header.sequence, .first_token = first_token, .wall_ns = header.wall_ns, .samples = {}};
    std::uint64_t gaps = 0;
    for (const auto& composed : composed_) {
        record.samples.push_back(composed.samples);
        record.too_large += composed.too_large;
        gaps += composed.too_large > 0 ? 1 : 0;
    }
    // The entry is in flight, and has that many samples: this cannot fail.
    const auto dropped = readable ? record.too_large : header.samples;
    if (dropped > 0) static_cast<void>(journal_.reject(destination_, header.sequence, dropped, gaps));
    if (!readable) rejected_ += header.samples;
    records_.push_back(std::move(record));
    finish_records(now, finished_token_);
    return true;
}

StreamPlace JournalMessages::place_of(const store::RecordHeader& header, std::uint64_t first_token) const {
    StreamPlace place{.epoch = header.epoch,
                      .first = header.samples_before + 1,
                      .packet_limit = limits_.packet,
                      .version = limits_.version};
    if (header.sequence <= last_of_earlier_run_ || other_limits_token_ >= first_token)
        place.repeated = MessageComposer::kMostMessages;
    else if (highest_token_ >= first_token)
        place.repeated = static_cast<std::size_t>(highest_token_ - first_token) + 1;
    return place;
}

/// @returns whether the record can be read
bool JournalMessages::compose(const store::JournalEntry& entry, const StreamPlace& place) {
    composed_.clear();
    next_ = 0;
    if (entry.gap) {
        composer_.compose(*entry.gap, place, composed_);
        return true;
    }
    const auto batch = decode_samples(entry.payload);
    if (batch) composer_.compose(*batch, place, composed_);
    return batch.has_value();
}

void JournalMessages::acknowledge(Instant now, std::uint64_t token) {
    TAKT_ASSERT(token > finished_token_);
    finished_token_ = token;
    finish_records(now, token);
}

void JournalMessages::reject(Instant now, std::uint64_t token, MqttReason) {
    TAKT_ASSERT(!records_.empty());
    const auto& record = records_.front();
    const auto index = static_cast<std::size_t>(token - record.first_token);
    TAKT_ASSERT(index < record.samples.size());
    const auto samples = record.samples[index];
    rejected_ += samples;
    if (samples > 0) static_cast<void>(journal_.reject(destination_, record.sequence, samples));
    acknowledge(now, token);
}

// A record without messages has no token of its own, and ends with the one before it.
void JournalMessages::finish_records(Instant now, std::uint64_t token) {
    while (!records_.empty()) {
        const auto& record = records_.front();
        const bool has_messages = !record.samples.empty();
        if (has_messages && record.first_token + record.samples.size() - 1 > token) return;
        static_cast<void>(journal_.acknowledge(now, destination_, record.sequence));
        too_large_ += record.too_large;
        records_.pop_front();
        if (records_.empty()) composed_.clear();
    }
}

void JournalMessages::rewind() {
    journal_.rewind(destination_);
    records_.clear();
    composed_.clear();
    next_ = 0;
}

std::optional<std::int64_t> JournalMessages::oldest_in_flight_ns() const {
    if (records_.empty()) return std::nullopt;
    return records_.front().wall_ns;
}

}  // namespace takt::publish
