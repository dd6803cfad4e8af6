// The gaps of the stream: each one where samples are missing, with their number, times and cause.
#include <algorithm>

#include "stream_judge.hpp"

namespace takt::gatewaysim {
namespace {

std::string gap_text(const SeenGap& gap) {
    return gap.cause + " of " + std::to_string(gap.samples) + " from " + std::to_string(gap.number) +
           " on, " + gap.first + " to " + gap.last;
}

}  // namespace

void StreamJudge::check_gap(const SeenMessage& message) {
    const auto& gap = *message.gap;
    if (gap.cause == "restart") return check_restart(message);
    if (gap.cause == "too_large") return check_too_large(message);
    if (gap.cause == "quota" || gap.cause == "damaged") return check_found_gap(message);
    check_written_gap(message);
}

void StreamJudge::check_restart(const SeenMessage& message) {
    const auto& gap = *message.gap;
    const Run* run = account_.run_of(message.epoch);
    const auto* record = run ? journal_.record(run->first_sequence) : nullptr;
    if (record == nullptr || gap.number != run->base + 1 || gap.samples != 0)
        return fail("gap_true", "the gap of a start, in its place and without a number", gap_text(gap));
    if (run->first_sequence > journal_.durable_sequence())
        fail("durable_first", "only what is durable is published", gap_text(gap));
    if (gap.first != time_text(record->facts.gap->first_wall_ns) ||
        gap.last != time_text(record->facts.gap->last_wall_ns))
        fail(
            "gap_true",
            time_text(record->facts.gap->first_wall_ns) + " to " + time_text(record->facts.gap->last_wall_ns),
            gap_text(gap));
}

// With packets of this size only a long text is too large.
void StreamJudge::check_too_large(const SeenMessage& message) {
    const auto& gap = *message.gap;
    constexpr std::size_t kLong = 30;
    std::vector<std::int64_t> times;
    for (std::uint64_t number = gap.number; number < gap.number + gap.samples; ++number) {
        const auto* sample = sample_of(message.epoch, number);
        const auto* value = sample ? std::get_if<std::string>(&sample->value) : nullptr;
        if (!packet_limit_ || value == nullptr || value->size() <= kLong)
            return fail("gap_true", "samples that are too large for a packet", gap_text(gap));
        times.push_back(sample->wall_ns);
        check_durable(number);
    }
    if (times.empty() || gap.first != time_text(*std::ranges::min_element(times)) ||
        gap.last != time_text(*std::ranges::max_element(times)))
        fail("gap_true", "the times of the samples that are too large", gap_text(gap));
}

/// A gap that was written to the journal: its truth was judged then.
void StreamJudge::check_written_gap(const SeenMessage& message) {
    const auto& gap = *message.gap;
    const auto* record = journal_.record_of_sample(gap.number);
    if (gap.samples == 0 || record == nullptr || !record->facts.gap ||
        record->facts.samples_before + 1 != gap.number || record->facts.samples != gap.samples ||
        record->facts.epoch != message.epoch || cause_name(record->facts.gap->cause) != gap.cause)
        return fail("gap_true", "a gap that was written", gap_text(gap));
    check_durable(record->facts.end());
    if (gap.first != time_text(record->facts.gap->first_wall_ns) ||
        gap.last != time_text(record->facts.gap->last_wall_ns))
        fail("gap_true", "the times that were written", gap_text(gap));
}

// A gap that was found while reading. All of its records are gone, and the next one is there. Where both the
// quota and damage took some of them, either is a true cause.
void StreamJudge::check_found_gap(const SeenMessage& message) {
    const auto& gap = *message.gap;
    // Records without samples end before the number of a gap in their place.
    const auto is_before = [&](const RecordFacts& facts) {
        return gap.samples == 0 ? facts.samples_before + 1 < gap.number : facts.end() < gap.number;
    };
    std::uint64_t sequence = 1;
    while (sequence <= journal_.last_sequence() && is_before(journal_.record(sequence)->facts)) ++sequence;
    // Gaps without samples that are in this place may have been delivered.
    while (sequence <= journal_.last_sequence() && journal_.record(sequence)->facts.samples == 0 &&
           journal_.record(sequence)->present)
        ++sequence;
    const auto first = sequence;
    // After damage, or without the note in the cursor of what the quota removed, either cause is possible.
    // The rest of a failed write looks like damage: what was behind it may have been in the same segment.
    // What the quota removed and what is damaged behind it are two gaps.
    const bool either = journal_.was_damaged() || journal_.is_torn(first - 1) ||
                        std::ranges::any_of(account_.runs(), &Run::cursor_failed);
    const auto is_gone = [&](const JournalJudge::Entry& entry) {
        return either || gap.cause == "quota" ? !entry.present : entry.unreadable || entry.doubtful;
    };
    std::uint64_t samples = 0;
    const auto may_end_before = [&](const JournalJudge::Entry& entry) {
        const bool complete = sequence > first && samples == gap.samples && entry.facts.samples > 0;
        return complete && (either || entry.unreadable);
    };
    while (sequence <= journal_.durable_sequence() && is_gone(*journal_.record(sequence)) &&
           !may_end_before(*journal_.record(sequence)))
        samples += journal_.record(sequence++)->facts.samples;
    if (sequence == first || samples != gap.samples)
        return fail("gap_true",
                    std::to_string(samples) + " samples are gone there, in " +
                        std::to_string(sequence - first) + " records",
                    gap_text(gap));
    for (const Run& run : account_.runs())
        if (run.epoch != 0 && run.first_sequence >= first && run.first_sequence < sequence)
            restarts_.push_back(run.number);
    if (journal_.was_damaged()) return;
    const auto* after = journal_.record(std::min(sequence, journal_.durable_sequence()));
    if (gap.last != time_text(after->facts.wall_ns) || message.epoch != after->facts.epoch)
        fail("gap_true",
             "the time and epoch of the record after: " + time_text(after->facts.wall_ns) + ", epoch " +
                 std::to_string(after->facts.epoch),
             gap_text(gap));
    if (!begins_behind(gap, first) && gap.first != gap.last)
        fail("gap_true", "the time of the last record before that was delivered", gap_text(gap));
}

// The record before is gone too if another gap is before this one. A gap begins no later than it ends: if the
// clock was set back meanwhile, that other gap began with the time of the first record of this one.
bool StreamJudge::begins_behind(const SeenGap& gap, std::uint64_t sequence) const {
    const bool after_gap = sequence > 1 && !journal_.record(sequence - 1)->present;
    if (after_gap && gap.first == time_text(journal_.record(sequence)->facts.wall_ns)) return true;
    for (; sequence > 1; --sequence) {
        const auto* before = journal_.record(sequence - 1);
        if (gap.first == time_text(before->facts.wall_ns)) return true;
        if (before->present) return false;
    }
    return gap.first == time_text(journal_.record(1)->facts.gap->first_wall_ns);
}

}  // namespace takt::gatewaysim
