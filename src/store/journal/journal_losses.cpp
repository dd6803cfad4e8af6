#include "journal/journal_losses.hpp"

#include <algorithm>
#include <iterator>

namespace takt::store {
namespace {

constexpr std::size_t kStepBytes = 256U << 10;

}  // namespace

// Ranges that overlap are one gap. Ranges that touch each other are two, but for those of the quota: the
// reader makes one gap of all segments that it removed.
void KnownLosses::add(std::uint64_t before, std::uint64_t samples, GapCause cause) {
    if (samples == 0) return;
    std::uint64_t begin = before;
    std::uint64_t end = before + samples;
    const auto joins = [&](const auto& known) {
        const auto& [its_begin, range] = known;
        const bool both_quota = cause == GapCause::quota && range.cause == GapCause::quota;
        return both_quota ? its_begin <= end && range.end >= begin : its_begin < end && range.end > begin;
    };
    auto known = ranges_.upper_bound(begin);
    if (known != ranges_.begin()) --known;
    while (known != ranges_.end() && known->first <= end) {
        if (!joins(*known)) {
            ++known;
            continue;
        }
        begin = std::min(begin, known->first);
        end = std::max(end, known->second.end);
        samples_ -= known->second.end - known->first;
        known = ranges_.erase(known);
    }
    if (ranges_.size() >= kMostRanges) return;
    ranges_.emplace(begin, Range{end, cause});
    samples_ += end - begin;
}

void KnownLosses::forget(std::uint64_t samples) {
    while (!ranges_.empty() && ranges_.begin()->second.end <= samples) {
        samples_ -= ranges_.begin()->second.end - ranges_.begin()->first;
        ranges_.erase(ranges_.begin());
    }
}

KnownLosses::Sum KnownLosses::after(std::uint64_t samples) const {
    Sum sum{samples_, ranges_.size()};
    for (auto range = ranges_.begin(); range != ranges_.end() && range->first < samples; ++range) {
        sum.samples -= std::min(range->second.end, samples) - range->first;
        if (range->second.end <= samples) --sum.gaps;
    }
    return sum;
}

void LossSurvey::begin(const StreamPosition& start) {
    reader_.emplace(*segments_, *storage_, start);
    last_ = segments_->durable.sequence;
}

Result<void> LossSurvey::step() {
    std::size_t bytes = 0;
    while (reader_ && bytes < kStepBytes) {
        if (reader_->position().sequence >= last_) {
            reader_.reset();
            break;
        }
        TAKT_TRY(const auto entry, reader_->next());
        if (!entry) {
            reader_.reset();
            break;
        }
        if (entry->gap) losses_->add(entry->header.samples_before, entry->header.samples, entry->gap->cause);
        bytes += kRecordOverheadBytes + entry->payload.size();
    }
    return {};
}

}  // namespace takt::store
