// What a record may hold, and when a segment may go.
#include <algorithm>

#include "journal_judge.hpp"

namespace takt::gatewaysim {
namespace {

constexpr std::uint64_t kGapRecords = 4096;  // more than the gap records in a buffer take

std::string times(std::int64_t first, std::int64_t last) {
    return std::to_string(first) + ".." + std::to_string(last);
}

}  // namespace

void JournalJudge::check_restart(const RecordFacts& first) {
    const Run& run = account_.current();
    const bool restart = first.gap && first.gap->cause == kRestart;
    if (!restart || first.sequence != run.first_sequence || first.samples != 0)
        return fail("gap_true", "a gap `restart` without samples, as the first record of a run", text(first));
    if (damaged_) return;
    const std::int64_t before = entries_.empty() ? run.opened_wall_ns : entries_.back().facts.wall_ns;
    if (first.gap->first_wall_ns != before || first.gap->last_wall_ns != run.opened_wall_ns)
        fail("gap_true", "from the last durable record to the start: " + times(before, run.opened_wall_ns),
             times(first.gap->first_wall_ns, first.gap->last_wall_ns));
}

void JournalJudge::check_samples(const RecordFacts& facts, Bytes payload) {
    const Run& run = account_.current();
    const Unit* unit = run.unit_of(facts.samples_before + 1);
    if (unit == nullptr || unit->lost() || run.base + unit->offset != facts.samples_before ||
        unit->count() != facts.samples || !std::ranges::equal(unit->queued.payload, payload))
        return fail("content_true", "the samples that were taken in this place", text(facts));
    if (facts.wall_ns != unit->queued.last_wall_ns)
        fail("content_true", "the time of the newest sample, " + std::to_string(unit->queued.last_wall_ns),
             text(facts) + " with " + std::to_string(facts.wall_ns));
}

void JournalJudge::check_gap(const RecordFacts& facts) {
    const Run& run = account_.current();
    const Unit* const first = run.unit_of(facts.samples_before + 1);
    if (first == nullptr || run.base + first->offset != facts.samples_before)
        return fail("gap_true", "a gap in the place of samples that were taken", text(facts));
    std::int64_t first_wall = first->queued.first_wall_ns;
    std::int64_t last_wall = first->queued.last_wall_ns;
    std::uint64_t end = facts.samples_before;
    bool could_fit = false;
    for (const Unit* unit = first; unit != nullptr && end < facts.end(); unit = run.unit_of(end + 1)) {
        first_wall = std::min(first_wall, unit->queued.first_wall_ns);
        last_wall = std::max(last_wall, unit->queued.last_wall_ns);
        end += unit->count();
        could_fit = could_fit || (!unit->lost() && !unit->did_not_fit);
    }
    if (end != facts.end())
        return fail("gap_true", "whole records are missing, up to sample " + std::to_string(end),
                    text(facts));
    if (facts.gap->first_wall_ns != first_wall || facts.gap->last_wall_ns != last_wall)
        fail("gap_true", text(facts) + " with the times of what is missing: " + times(first_wall, last_wall),
             times(facts.gap->first_wall_ns, facts.gap->last_wall_ns));
    check_cause(facts, *first, could_fit);
}

/// @param could_fit  samples are missing that reached the journal
void JournalJudge::check_cause(const RecordFacts& facts, const Unit& first, bool could_fit) {
    const auto cause = facts.gap->cause;
    complaints_.count("gap_" + cause_name(cause));
    const Run& run = account_.current();
    if (first.lost() && !first.did_not_fit) {
        if (cause != kSourceLost)
            fail("gap_true", "the cause of the first missing sample, source_lost", text(facts));
    } else {
        bool is_true = false;
        for (std::size_t i = 0; i < states_.size(); ++i) {
            const bool over = i + 1 < states_.size() && states_[i + 1].first < first.pushed;
            is_true = is_true || (!over && states_[i].second == cause);
        }
        if (!is_true) fail("gap_true", "the state of the disk while the samples waited", text(facts));
    }
    if (!could_fit) return;
    std::uint64_t most = 0;
    for (auto unit = run.units.rbegin(); unit != run.units.rend() && unit->offset >= first.offset; ++unit)
        most = std::max(most, unit->not_durable);
    if (most + kGapRecords < scenario_.journal.buffer_bytes)
        fail("gap_true",
             "nothing is lost while the buffer has room: at most " + std::to_string(most) + " bytes waited",
             text(facts));
}

// What is not acknowledged goes only where the quota has no room for a further segment.
void JournalJudge::check_removal(std::uint64_t segment) {
    std::uint64_t total = 0;
    for (const auto& [its, bytes] : segments_) total += bytes;
    const bool full = total + scenario_.journal.segment_bytes > scenario_.journal.quota_bytes;
    for (const Entry& entry : entries_) {
        if (entry.segment != segment || !entry.present || entry.facts.sequence <= cursor_.sequence) continue;
        if (entry.state == State::written) continue;  // it will be written again
        complaints_.count("dropped_by_quota");
        if (!full && !damaged_)
            fail("segment_kept",
                 "no removal of what is not acknowledged below the quota: " + std::to_string(total) +
                     " bytes are used",
                 "removal of segment " + std::to_string(segment) + " with " + text(entry.facts));
        return;
    }
}

}  // namespace takt::gatewaysim
