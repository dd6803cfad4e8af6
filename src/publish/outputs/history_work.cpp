// A record is acknowledged after the commit that has it. After a crash in between, the journal gives it
// again, and the history skips it by its position: the identity of the journal and the record's sequence
// number. The identity is a random number beside the segments, so a journal that was deleted and begun again
// is another one.
#include "outputs/history_work.hpp"

#include <sys/random.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstring>
#include <fstream>
#include <utility>

#include "takt/os/replace.hpp"
#include "takt/publish/sample_codec.hpp"
#include "takt/publish/wall_clock.hpp"

namespace takt::publish {
namespace {

std::string error_text(const Error& error) {
    std::string text(name(error.code));
    text += " " + std::string(error.subject.view());
    if (error.numbers[0] > 0) text += std::string(": ") + std::strerror(static_cast<int>(error.numbers[0]));
    return text;
}

Result<std::uint64_t> identity_in(const std::string& folder) {
    const auto path = folder + "/identity";
    std::uint64_t identity = 0;
    if (std::ifstream(path) >> std::hex >> identity && identity != 0) return identity;
    if (::getrandom(&identity, sizeof identity, 0) != sizeof identity) return fail(Code::io_failed, path);
    TAKT_TRY(auto file, os::FileReplacement::begin(path, {}));
    {
        std::ofstream stream(file.temporary());
        stream << std::hex << identity << '\n';
        if (!stream.flush()) return fail(Code::io_failed, path);
    }
    TAKT_CHECK(file.commit());
    return identity;
}

}  // namespace

void HistoryWork::begin(Instant now, store::Journal& journal, store::DestinationId destination) {
    journal_ = &journal;
    destination_ = destination;
    next_ = now;
}

Result<void> HistoryWork::open() {
    if (history_) return {};
    TAKT_TRY(identity_, identity_in(journal_folder_));
    TAKT_TRY(auto opened, store::History::open(path_, options_));
    history_ = std::move(opened.history);
    if (!opened.set_aside.empty()) set_aside_ = opened.set_aside;
    damaged_ += opened.damage.size();
    series_.clear();
    records_ = 0;
    journal_->rewind(destination_);
    return {};
}

Result<store::SeriesId> HistoryWork::series_of(const Series& series) {
    const auto known = series_.find(series.variable);
    if (known != series_.end() && known->second.first == series) return known->second.second;
    TAKT_TRY(const auto id, history_->series({.name = series.variable,
                                              .device = series.device,
                                              .type = series.type,
                                              .scaled = series.scaled,
                                              .unit = series.unit}));
    series_.insert_or_assign(series.variable, std::pair(series, id));
    return id;
}

Result<void> HistoryWork::append(const store::JournalEntry& entry) {
    history_->begin_record({identity_, entry.header.sequence});
    if (entry.gap) {
        const auto& gap = *entry.gap;
        // The first start of a journal is no gap: nothing was recorded before.
        if (gap.first_wall_ns == gap.last_wall_ns && gap.samples == 0) return {};
        history_->append(store::HistoryGap{gap.first_wall_ns, gap.last_wall_ns, gap.cause, gap.samples});
        return {};
    }
    const auto batch = decode_samples(entry.payload);
    if (!batch) {
        unreadable_ += entry.header.samples;
        return journal_->reject(destination_, entry.header.sequence, entry.header.samples);
    }
    for (const auto& sample : batch->samples) {
        TAKT_TRY(const auto series, series_of(batch->series[sample.series]));
        const bool good = sample.quality == value::Quality::good;
        history_->append(series, {.time_ns = sample.wall_ns,
                                  .previous_ns = good ? sample.previous_wall_ns : std::nullopt,
                                  .value = sample.value,
                                  .quality = sample.quality,
                                  .reason = sample.reason});
    }
    return {};
}

// A commit without samples notes up to when the values are known.
Result<bool> HistoryWork::take(Instant now) {
    TAKT_CHECK(open());
    bool more = true;
    while (records_ < kMostRecords) {
        TAKT_TRY(const auto entry, journal_->read(destination_));
        more = entry.has_value();
        if (!more) break;
        TAKT_CHECK(append(*entry));
        last_sequence_ = entry->header.sequence;
        ++records_;
    }
    TAKT_CHECK(history_->commit(system_wall_ns(now)));
    if (records_ > 0) TAKT_CHECK(journal_->acknowledge(now, destination_, last_sequence_));
    records_ = 0;
    return more;
}

// One commit a call: the thread takes new samples in between, and a long call shows that the disk hangs.
void HistoryWork::work(Instant now) {
    if (stopped_ || now < next_) return;
    const auto more = take(now);
    if (!more) return fail_with(now, more.error());
    failure_.reset();
    next_ = *more ? now : now + kCommitEvery;
}

// What was appended and not committed is forgotten, and read from the journal again.
void HistoryWork::fail_with(Instant now, const Error& error) {
    failure_ = error;
    if (const auto aside = history_ ? history_->status().set_aside : std::string(); !aside.empty())
        set_aside_ = aside;
    history_.reset();
    next_ = now + kTryAgain;
}

void HistoryWork::stop(Instant now) {
    if (stopped_) return;
    do {
        next_ = now;
        work(now);
    } while (next_ == now);
    stopped_ = true;
    history_.reset();
}

void HistoryWork::report(Instant, OutputStatus& status) const {
    status.state = failure_ ? OutputState::waiting : OutputState::delivering;
    status.destination = path_;
    if (failure_) status.failure = error_text(*failure_);
    status.damaged = damaged_;
    status.set_aside = set_aside_;
}

}  // namespace takt::publish
