#include "journal_judge.hpp"

#include <algorithm>
#include <cerrno>

namespace takt::gatewaysim {
namespace {

constexpr std::uint64_t kOverhead = 64;  // of a record

std::string failed(int error) {
    return error == 0 ? "" : ", error " + std::to_string(error);
}

}  // namespace

void JournalJudge::on_run_begin(Disk& disk, bool damaged) {
    damaged_ = damaged_ || damaged;
    for (Entry& entry : entries_) entry.present = false;  // until it is found
    segments_.clear();
    torn_.clear();
    for (const auto& [segment, bytes] : disk.contents()) {
        segments_[segment] = bytes.size();
        std::uint64_t of_records = 0;
        for (const auto& read : read_records(bytes)) {
            of_records += read.payload.size() + kOverhead;
            const auto sequence = read.facts.sequence;
            if (sequence == 0 || sequence > entries_.size()) continue;
            Entry& entry = entries_[sequence - 1];
            if (!(entry.facts == read.facts)) continue;  // of a run whose end was lost
            entry.segment = segment;
            entry.present = true;
        }
        if (of_records != bytes.size()) torn_.insert(segment);
    }
    find_recovered();
    cursor_ = {};
    bool found = false;
    for (unsigned slot = 0; slot < 2; ++slot) {
        const auto read = read_cursor(disk.cursor("cloud", slot));
        if (read && (!found || read->counter > cursor_.counter)) cursor_ = *read;
        found = found || read.has_value();
    }
    if (!found && !disk.cursor("cloud", 0).empty()) {
        cursor_damaged_ = true;
        const auto oldest = std::ranges::find_if(entries_, &Entry::present);
        if (oldest != entries_.end()) deliveries_->on_cursor_lost(oldest->facts.samples_before);
    }
    durable_units_ = 0;
    not_durable_bytes_ = 0;
    states_.assign(1, {clock_.now, kBufferFull});
}

// The stream ends with the last record of the last segment that has one. What other segments have behind it
// was not synchronised, and is ignored.
void JournalJudge::find_recovered() {
    recovered_ = 0;
    std::uint64_t last = 0;
    for (const Entry& entry : entries_)
        if (entry.present && entry.segment >= last) {
            last = entry.segment;
            recovered_ = entry.facts.sequence;
        }
    for (Entry& entry : entries_) {
        if (entry.facts.sequence > recovered_) entry.present = false;
        entry.unreadable = !entry.present && (entry.unreadable || segments_.contains(entry.segment));
    }
    recovered_ = std::max(recovered_, durable_sequence_);
}

void JournalJudge::on_decay(std::uint64_t sequence) {
    damaged_ = true;
    entries_.at(sequence - 1).present = false;
    entries_.at(sequence - 1).unreadable = true;
}

void JournalJudge::on_pushed(Unit& unit) {
    not_durable_bytes_ += unit.queued.payload.size() + kOverhead;
    unit.not_durable = not_durable_bytes_;
}

void JournalJudge::on_listed() {
    account_.current().opened_wall_ns = clock_.wall_ns();
}

void JournalJudge::on_create(std::uint64_t segment, int error) {
    complaints_.trace(clock_.now, [&] { return "disk: create " + std::to_string(segment) + failed(error); });
    segments_[segment] = 0;
    if (error != 0) note_state(error == ENOSPC ? kDiskFull : kDiskFailed);
}

void JournalJudge::on_append(std::uint64_t segment, Bytes bytes, int error) {
    complaints_.trace(clock_.now,
                      [&] { return "disk: append to " + std::to_string(segment) + failed(error); });
    segments_[segment] += bytes.size();
    for (const auto& read : read_records(bytes)) take(read, segment);
    if (error != 0) note_state(error == ENOSPC ? kDiskFull : kDiskFailed);
}

void JournalJudge::take(const ReadRecord& read, std::uint64_t segment) {
    const auto& facts = read.facts;
    complaints_.trace(clock_.now, [&] { return "      " + text(facts); });
    if (account_.current().epoch == 0) begin_epoch(facts);
    if (facts.sequence <= entries_.size()) {
        Entry& before = entries_[facts.sequence - 1];
        if (!(before.facts == facts))
            fail("sequence_unique", text(before.facts) + ", which has this number", text(facts));
        // Written again because the former segment was abandoned.
        before.segment = segment;
        before.present = true;
        before.unreadable = before.doubtful = false;
        return;
    }
    const std::uint64_t end = entries_.empty() ? 0 : entries_.back().facts.end();
    if (facts.sequence != entries_.size() + 1 || facts.samples_before != end)
        return fail("sequence_unique",
                    "record " + std::to_string(entries_.size() + 1) + " from sample " +
                        std::to_string(end + 1) + " on",
                    text(facts));
    if (facts.epoch != account_.current().epoch)
        return fail("sequence_unique", "epoch " + std::to_string(account_.current().epoch), text(facts));
    const bool restart = facts.gap && facts.gap->cause == kRestart;
    if (restart || facts.sequence == account_.current().first_sequence)
        check_restart(facts);
    else if (!facts.gap)
        check_samples(facts, read.payload);
    else
        check_gap(facts);
    entries_.push_back({.facts = facts, .segment = segment});
}

// The first record of a run. What the disk lost of the run before is forgotten: nobody saw it.
void JournalJudge::begin_epoch(const RecordFacts& first) {
    Run& run = account_.current();
    std::uint64_t last_epoch = 0;
    for (const Entry& entry : entries_)
        if (entry.state == State::durable) last_epoch = entry.facts.epoch;
    if (!damaged_ && (first.sequence <= kept_sequence_ || first.samples_before < kept_samples_))
        fail("sequence_unique",
             "after record " + std::to_string(kept_sequence_) + " and sample " +
                 std::to_string(kept_samples_) + ", which are durable",
             text(first));
    if (!damaged_ && first.epoch <= last_epoch)
        fail("sequence_unique", "an epoch above " + std::to_string(last_epoch), text(first));
    if (!damaged_ && first.sequence > entries_.size() + 1)
        fail("sequence_unique", "at most record " + std::to_string(entries_.size() + 1), text(first));
    run.epoch = first.epoch;
    run.base = first.samples_before;
    run.first_sequence = first.sequence;
    for (Run& earlier : account_.runs()) {
        if (&earlier == &run) continue;
        if (!earlier.end) earlier.end = run.base;
        if (earlier.epoch == run.epoch) earlier.epoch = 0;  // nothing of it is left
    }
    // Only after damage the stream may go on beyond what the judge knows.
    while (entries_.size() + 1 < first.sequence)
        entries_.push_back(
            {.facts = {.sequence = entries_.size() + 1, .samples_before = first.samples_before},
             .present = false,
             .unreadable = true});
    entries_.resize(first.sequence - 1);
    kept_sequence_ = std::min(kept_sequence_, first.sequence - 1);
    for (Entry& entry : entries_) entry.state = State::durable;
    durable_sequence_ = first.sequence - 1;
    durable_samples_ = first.samples_before;
    note_kept();
    deliveries_->on_cut(first.samples_before);
    complaints_.count("epoch");
}

void JournalJudge::note_state(std::uint16_t cause) {
    if (states_.back().second != cause) states_.emplace_back(clock_.now, cause);
}

void JournalJudge::on_sync(std::uint64_t segment, int error) {
    complaints_.trace(clock_.now, [&] { return "disk: sync " + std::to_string(segment) + failed(error); });
    if (error != 0) {
        // The system may have dropped these pages, although they can still be read.
        for (std::size_t i = durable_sequence_; i < entries_.size(); ++i)
            if (entries_[i].segment == segment) entries_[i].doubtful = true;
        return note_state(error == ENOSPC ? kDiskFull : kDiskFailed);
    }
    note_state(kBufferFull);
    Run& run = account_.current();
    if (run.epoch == 0) {
        // The program makes durable what an earlier run left, before it reads it.
        durable_sequence_ = recovered_;
        if (recovered_ > 0) durable_samples_ = entries_[recovered_ - 1].facts.end();
        return note_kept();
    }
    for (std::size_t i = durable_sequence_; i < entries_.size() && entries_[i].segment == segment; ++i) {
        entries_[i].state = State::durable;
        durable_sequence_ = i + 1;
        durable_samples_ = entries_[i].facts.end();
    }
    note_kept();
    for (; durable_units_ < run.units.size(); ++durable_units_) {
        const Unit& unit = run.units[durable_units_];
        if (run.base + unit.offset + unit.count() > durable_samples_) break;
        not_durable_bytes_ -= unit.queued.payload.size() + kOverhead;
    }
}

/// The last record that no crash may take.
void JournalJudge::note_kept() {
    std::uint64_t sequence = durable_sequence_;
    while (sequence > kept_sequence_ && entries_[sequence - 1].doubtful) --sequence;
    if (sequence <= kept_sequence_) return;
    kept_sequence_ = sequence;
    kept_samples_ = entries_[sequence - 1].facts.end();
}

void JournalJudge::on_remove(std::uint64_t segment, int error) {
    complaints_.trace(clock_.now, [&] { return "disk: remove " + std::to_string(segment) + failed(error); });
    if (error != 0) return;
    check_removal(segment);
    segments_.erase(segment);
    for (Entry& entry : entries_)
        if (entry.segment == segment) entry.present = false;
}

void JournalJudge::on_cursor_written(Bytes bytes, int error) {
    complaints_.trace(clock_.now, [&] { return "disk: cursor written" + failed(error); });
    if (error != 0) account_.current().cursor_failed = true;
    const auto facts = read_cursor(bytes);
    if (!facts) return fail("cursor_true", "a cursor", "other bytes");
    written_cursor_ = *facts;
    if (const auto missing = deliveries_->unfinished(facts->sequence, facts->samples))
        fail("cursor_true", "only what the broker has acknowledged counts as delivered",
             "the cursor is at record " + std::to_string(facts->sequence) + ", sample " +
                 std::to_string(facts->samples) + ", but " + *missing);
    if (!damaged_ && !cursor_damaged_ && facts->delivered + facts->dropped != facts->samples)
        fail("conserved", "delivered + dropped = " + std::to_string(facts->samples),
             std::to_string(facts->delivered) + " + " + std::to_string(facts->dropped));
}

void JournalJudge::on_cursor_synced(int error) {
    complaints_.trace(clock_.now, [&] { return "disk: cursor synchronised" + failed(error); });
    if (error != 0) {
        account_.current().cursor_failed = true;
        return;
    }
    if (written_cursor_.counter >= cursor_.counter) cursor_ = written_cursor_;
}

const JournalJudge::Entry* JournalJudge::record(std::uint64_t sequence) const {
    return sequence == 0 || sequence > entries_.size() ? nullptr : &entries_[sequence - 1];
}

const JournalJudge::Entry* JournalJudge::record_of_sample(std::uint64_t number_in_stream) const {
    const auto found = std::ranges::lower_bound(entries_, number_in_stream, {},
                                                [](const Entry& entry) { return entry.facts.end(); });
    return found == entries_.end() ? nullptr : &*found;
}

}  // namespace takt::gatewaysim
