#include "history/history_fold.hpp"

#include <algorithm>
#include <utility>

#include "takt/store/history_codec.hpp"

namespace takt::store {
namespace {

constexpr std::size_t kMostOpenSamples = 500'000;  // some 40 MB
constexpr std::int64_t kGapMemory = 3 * kHour;
constexpr std::size_t kMostGaps = 10'000;

std::int64_t hour_of(std::int64_t time_ns) {
    return time_ns / kHour - (time_ns % kHour < 0 ? 1 : 0);
}

/// The number of samples of the next chunk: within an hour.
std::size_t chunk_length(std::span<const HistorySample> samples, std::size_t most) {
    std::size_t length = 1;
    while (length < std::min(samples.size(), most) &&
           hour_of(samples[length].time_ns) == hour_of(samples[0].time_ns))
        ++length;
    return length;
}

}  // namespace

void OpenChunks::load(const DecodedLog& log) {
    for (const auto& logged : log.samples) add(logged);
}

void OpenChunks::load(const ChunkRow& row, const std::vector<HistorySample>& samples) {
    for (const auto& sample : samples) add(LoggedSample{row.series, sample});
    entries_[row.series.value].changed = false;
    entries_[row.series.value].row = Row{row.id, row.summary.begin_ns};
}

void OpenChunks::load(const HistoryGaps& gaps) {
    std::int64_t oldest = INT64_MAX;
    for (const Entry& entry : entries_)
        for (const auto& sample : entry.samples) oldest = std::min(oldest, sample.time_ns);
    if (samples_ > 0) gaps_ = gaps_in(gaps, oldest, INT64_MAX);
}

void OpenChunks::add(const LoggedSample& logged) {
    if (logged.series.value >= entries_.size()) entries_.resize(logged.series.value + 1);
    Entry& entry = entries_[logged.series.value];
    entry.samples.push_back(logged.sample);
    entry.changed = true;
    ++samples_;
}

void OpenChunks::add(const HistoryGap& gap) {
    const auto place = std::ranges::upper_bound(gaps_, gap.first_ns, {}, &HistoryGap::first_ns);
    gaps_.insert(place, gap);
    const std::int64_t old = gap.last_ns - kGapMemory;
    if (gaps_.size() > kMostGaps)
        std::erase_if(gaps_, [old](const HistoryGap& entry) { return entry.last_ns < old; });
}

void OpenChunks::fold(SQLite::Database& database, HistoryState& state, std::int64_t wall_ns) {
    ChunkWriter writer(database);
    closed_ = 0;
    close_all_ = samples_ > kMostOpenSamples;
    for (std::size_t i = 0; i < entries_.size(); ++i)
        fold(writer, SeriesId{static_cast<std::uint32_t>(i)}, entries_[i], wall_ns);
    writer.finish(state);
    clear_log(database, state);
}

void OpenChunks::fold(ChunkWriter& writer, SeriesId series, Entry& entry, std::int64_t wall_ns) {
    entry.closed = 0;
    entry.next_row = entry.row;
    if (entry.samples.empty()) return;
    const std::int64_t hour = hour_of(wall_ns);
    const bool is_over = hour_of(entry.samples.back().time_ns) < hour;
    if (!entry.changed && !is_over && !close_all_) return;
    if (entry.changed) std::ranges::stable_sort(entry.samples, {}, &HistorySample::time_ns);
    if (entry.row) writer.erase(series, entry.row->begin_ns, entry.row->id);
    entry.next_row.reset();
    std::span<const HistorySample> left(entry.samples);
    while (!left.empty()) {
        const auto samples = left.first(chunk_length(left, chunk_samples_));
        left = left.subspan(samples.size());
        ChunkRow row{.id = next_id_++, .series = series, .summary = summary_of(samples, gaps_)};
        row.open = left.empty() && samples.size() < chunk_samples_ && !close_all_ &&
                   hour_of(samples.back().time_ns) >= hour;
        writer.write(row, encode_history(samples, {.compress = !row.open}));
        if (row.open) {
            entry.next_row = Row{row.id, row.summary.begin_ns};
        } else {
            entry.closed += samples.size();
            ++closed_;
        }
    }
}

std::size_t OpenChunks::folded() {
    for (Entry& entry : entries_) {
        entry.row = entry.next_row;
        entry.changed = false;
        samples_ -= entry.closed;
        entry.samples.erase(
            entry.samples.begin(),
            entry.samples.begin() + static_cast<std::ptrdiff_t>(std::exchange(entry.closed, 0)));
        if (entry.samples.empty()) entry.samples.shrink_to_fit();
    }
    return std::exchange(closed_, 0);
}

}  // namespace takt::store
