// A query takes the rows of chunks, which are roll-ups, and the samples of the log. Chunks do not overlap,
// unless the clock was set back: those are decoded and merged. Else a chunk that fits into a pixel is taken
// as its roll-up, and the others are decoded. No extreme is lost either way.
#include "takt/store/history_reader.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "history/history_chunks.hpp"
#include "history/history_file.hpp"
#include "history/history_picture.hpp"
#include "history/history_schema.hpp"
#include "history/history_tables.hpp"

namespace takt::store {
namespace {

using Samples = std::vector<HistorySample>;

constexpr std::size_t kMostPixels = 100'000;

std::int64_t begin_of(const ChunkRow& row) {
    return row.summary.begin_ns;
}

/// Chunks that overlap in time, as a part of the list.
using Cluster = std::span<const ChunkRow>;

/// The position of a row in the order of arrival: chunks are numbered in that order, and the log is newer
/// than all of them.
std::int64_t arrival(const ChunkRow& row) {
    return row.id == 0 ? INT64_MAX : row.id;
}

// Neighbours that share an instant are joined if the second one arrived first: samples of one instant stay in
// the order of arrival.
Cluster next_cluster(Cluster chunks) {
    std::size_t length = 1;
    std::int64_t end = chunks[0].summary.end_ns;
    std::int64_t newest = arrival(chunks[0]);
    for (; length < chunks.size(); ++length) {
        const ChunkRow& next = chunks[length];
        if (next.summary.begin_ns > end) break;
        if (next.summary.begin_ns == end && arrival(next) > newest) break;
        end = std::max(end, next.summary.end_ns);
        newest = std::max(newest, arrival(next));
    }
    return chunks.first(length);
}

}  // namespace

struct HistoryReader::State {
    std::string path;
    std::unique_ptr<SQLite::Database> database;
    std::uint64_t damaged = 0;  // chunks and rows of the log that the current query lacks
    std::vector<HistoryDamage> damage;

    // Of the file at `version`; they are read again when a writer has changed it.
    std::optional<std::int64_t> version;
    HistoryState state;
    std::vector<SeriesRow> series;  // good ones
    HistoryGaps gaps;
    std::map<SeriesId, std::vector<ChunkRow>> rows;  // by their begin

    /// Runs `query` on one state of the file.
    template <class Query>
    auto consistent(Query query) -> Result<decltype(query())> {
        return with_results(path, database.get(), [&]() -> Result<decltype(query())> {
            SQLite::Transaction transaction(*database, SQLite::TransactionBehavior::DEFERRED);
            damaged = 0;
            refresh();
            return query();
        });
    }

    void refresh() {
        const std::int64_t now = database->execAndGet("PRAGMA data_version").getInt64();
        if (version == now) return;
        version.reset();
        rows.clear();
        state = read_state(*database);
        if (state.damaged) note({.part = HistoryPart::state});
        auto variables = read_series(*database, state);
        series = std::move(variables.rows);
        auto read = read_gaps(*database, state);
        note_all(read.damage);
        gaps = std::move(read.gaps);
        note_lost(std::move(variables.damage));
        version = now;
    }
    /// Notes damaged rows of variables with the times and the number of their samples.
    void note_lost(std::vector<HistoryDamage> lost) {
        std::erase_if(damage, [](const HistoryDamage& its) {
            return its.part == HistoryPart::series && its.row > 0;  // of an older version of the file
        });
        for (auto& its : lost) {
            if (its.row > 0) add_extent(its);
            note(its);
        }
    }
    void add_extent(HistoryDamage& lost) {
        const auto include = [&lost](std::int64_t first, std::int64_t last, std::uint64_t count) {
            lost.first_ns = std::min(lost.first_ns.value_or(first), first);
            lost.last_ns = std::max(lost.last_ns.value_or(last), last);
            lost.samples += count;
        };
        const SeriesId id{static_cast<std::uint32_t>(lost.row)};
        for (const ChunkRow& row : rows_of(id))
            include(row.summary.begin_ns, row.summary.end_ns, row.summary.samples);
        const auto log = logged(id);
        if (!log.empty()) include(log.front().time_ns, log.back().time_ns, log.size());
    }
    /// Whether a damaged row may be that of a variable that has no good one.
    bool is_lost(std::string_view variable) {
        const auto may_be = [variable](const HistoryDamage& its) {
            return its.part == HistoryPart::series && (its.variable.empty() || its.variable == variable);
        };
        if (std::ranges::none_of(damage, may_be)) return false;
        const auto named = std::ranges::find(damage, variable, &HistoryDamage::variable);
        if (named == damage.end() || named->part != HistoryPart::series)
            note({.part = HistoryPart::series, .variable = std::string(variable)});
        return true;
    }
    void note(const HistoryDamage& found) {
        if (std::ranges::find(damage, found) == damage.end()) damage.push_back(found);
    }
    void note_all(const std::vector<HistoryDamage>& all) {
        for (const auto& found : all) note(found);
    }
    /// Notes the gaps that a writer has put in the place of damaged samples.
    void note_recorded(const HistoryRange& range) {
        for (const auto& gap : gaps)
            if (gap.cause == GapCause::damaged && gap.last_ns >= range.from_ns && gap.first_ns < range.to_ns)
                note({.part = HistoryPart::recorded,
                      .first_ns = gap.first_ns,
                      .last_ns = gap.last_ns,
                      .samples = gap.samples});
    }
    /// The row of a variable; of a damaged one its number.
    SeriesRow row_of(SeriesId id) {
        const auto known = std::ranges::find(series, id, [](const SeriesRow& row) { return row.info.id; });
        if (known != series.end()) return *known;
        return {.info = {.id = id}, .chunks = kUnknownDigest};
    }
    const std::vector<ChunkRow>& rows_of(SeriesId id) {
        const auto known = rows.find(id);
        if (known != rows.end()) return known->second;
        auto read = read_chunks(*database, row_of(id), gaps);
        note_all(read.damage);
        return rows[id] = std::move(read.rows);
    }
    Samples samples_of(const ChunkRow& row) {
        auto samples = read_samples(*database, row);
        if (samples) return std::move(*samples);
        ++damaged;
        note(damage_of(row, row_of(row.series).info.series.name));
        return {};
    }
    /// The samples of the log, in order of time. The variables of a damaged row are unknown.
    Samples logged(SeriesId id) {
        Samples samples;
        const auto log = read_log(*database, state, newest_chunk_end(*database));
        note_all(log.damage);
        damaged += log.damage.size();
        for (const auto& entry : log.samples)
            if (entry.series == id) samples.push_back(entry.sample);
        std::ranges::stable_sort(samples, {}, &HistorySample::time_ns);
        return samples;
    }
    /// The rows of the chunks that overlap the range; the log is the last one, with number 0.
    std::vector<ChunkRow> chunks(SeriesId id, const HistoryRange& range, const Samples& log) {
        std::vector<ChunkRow> found;
        for (const ChunkRow& row : rows_of(id))
            if (row.summary.begin_ns < range.to_ns && row.summary.end_ns >= range.from_ns)
                found.push_back(row);
        if (!log.empty() && log.front().time_ns < range.to_ns && log.back().time_ns >= range.from_ns) {
            ChunkRow row{.series = id, .open = true};
            row.summary.begin_ns = log.front().time_ns;
            row.summary.end_ns = log.back().time_ns;
            row.summary.mixed = true;
            const auto place = std::ranges::upper_bound(found, row.summary.begin_ns, {}, begin_of);
            found.insert(place, row);
        }
        return found;
    }
    Samples merged(Cluster cluster, const Samples& log) {
        if (cluster.size() == 1) return cluster[0].id == 0 ? log : samples_of(cluster[0]);
        std::vector<ChunkRow> by_arrival(cluster.begin(), cluster.end());
        std::ranges::sort(by_arrival, {}, arrival);
        Samples all;
        for (const ChunkRow& row : by_arrival) {
            const auto samples = row.id == 0 ? log : samples_of(row);
            all.insert(all.end(), samples.begin(), samples.end());
        }
        std::ranges::stable_sort(all, {}, &HistorySample::time_ns);
        return all;
    }
    std::optional<HistorySample> before(SeriesId series, std::int64_t time_ns, const Samples& log);
    void draw(PictureBuilder& builder, Cluster cluster, const Samples& log);
    HistoryPicture picture(SeriesId series, const HistoryRange& range, std::size_t pixels);
};

// The newest sample before a time is in the chunk that begins last before it, or in one that overlaps that
// one. Of several at one instant, the one that came last counts.
std::optional<HistorySample> HistoryReader::State::before(SeriesId id, std::int64_t time_ns,
                                                          const Samples& log) {
    const auto& all = rows_of(id);
    const auto end = std::ranges::lower_bound(all, time_ns, {}, begin_of);
    std::optional<HistorySample> best;
    const auto take = [&](const Samples& samples) {
        const auto next = std::ranges::lower_bound(samples, time_ns, {}, &HistorySample::time_ns);
        if (next != samples.begin() && (!best || (next - 1)->time_ns >= best->time_ns)) best = *(next - 1);
    };
    if (end != all.begin()) {
        const std::int64_t begin = begin_of(*(end - 1));
        std::vector<ChunkRow> overlapping;
        std::copy_if(all.begin(), end, std::back_inserter(overlapping),
                     [begin](const ChunkRow& row) { return row.summary.end_ns >= begin; });
        std::ranges::sort(overlapping, {}, arrival);
        for (const ChunkRow& row : overlapping) take(samples_of(row));
    }
    take(log);
    return best;
}

void HistoryReader::State::draw(PictureBuilder& builder, Cluster cluster, const Samples& log) {
    if (cluster.size() == 1 && cluster[0].id != 0) {
        if (builder.fits(cluster[0].summary)) return builder.add(cluster[0].summary);
    }
    for (const auto& sample : merged(cluster, log)) builder.add(sample);
}

HistoryPicture HistoryReader::State::picture(SeriesId id, const HistoryRange& range, std::size_t pixels) {
    const Samples log = logged(id);
    const auto first = before(id, range.from_ns, log);
    const auto all_gaps =
        gaps_in(gaps, first ? std::min(first->time_ns, range.from_ns) : range.from_ns, range.to_ns);
    note_recorded(range);
    PictureBuilder builder(range, pixels, all_gaps);
    if (first) builder.begin(*first);
    const auto overlapping = chunks(id, range, log);
    for (Cluster left(overlapping); !left.empty();) {
        const Cluster cluster = next_cluster(left);
        draw(builder, cluster, log);
        left = left.subspan(cluster.size());
    }
    HistoryPicture picture = builder.finish(state.known_until_ns);
    picture.damaged_chunks = damaged;
    std::erase_if(picture.gaps, [&](const HistoryGap& gap) { return gap.last_ns < range.from_ns; });
    return picture;
}

HistoryReader::HistoryReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
HistoryReader::HistoryReader(HistoryReader&&) noexcept = default;
HistoryReader& HistoryReader::operator=(HistoryReader&&) noexcept = default;
HistoryReader::~HistoryReader() = default;

Result<HistoryReader> HistoryReader::open(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return fail(Code::not_found, path);
    if (!std::filesystem::is_regular_file(path, error)) return fail(Code::unsupported, path);
    auto state = std::make_unique<State>();
    state->path = path;
    TAKT_CHECK(with_results(path, nullptr, [&]() -> Result<void> {
        state->database = std::make_unique<SQLite::Database>(
            path, SQLite::OPEN_READONLY | SQLite::OPEN_NOMUTEX, kLockWaitMs);
        return {};
    }));
    const auto ours = with_results(path, state->database.get(), [&]() -> Result<void> {
        TAKT_CHECK(check_history(*state->database, path));
        view_history(*state->database);
        return {};
    });
    // A file of another program is not a damaged history.
    if (!ours && ours.error().code == Code::malformed) TAKT_CHECK(check_history_mark(path));
    TAKT_CHECK(ours);
    return HistoryReader(std::move(state));
}

Result<std::vector<HistorySeriesInfo>> HistoryReader::series() {
    return state_->consistent([&] {
        std::vector<HistorySeriesInfo> all;
        for (const SeriesRow& row : state_->series) all.push_back(row.info);
        return all;
    });
}

bool HistoryReader::is_lost(std::string_view variable) {
    return state_->is_lost(variable);
}

Result<std::optional<HistoryRange>> HistoryReader::extent(SeriesId series) {
    return state_->consistent([&] {
        std::optional<HistoryRange> extent;
        const auto include = [&extent](std::int64_t first, std::int64_t last) {
            if (!extent) extent = HistoryRange{first, last};
            extent->from_ns = std::min(extent->from_ns, first);
            extent->to_ns = std::max(extent->to_ns, last);
        };
        for (const ChunkRow& row : state_->rows_of(series)) include(row.summary.begin_ns, row.summary.end_ns);
        if (const auto log = state_->logged(series); !log.empty())
            include(log.front().time_ns, log.back().time_ns);
        return extent;
    });
}

Result<std::optional<HistorySample>> HistoryReader::before(SeriesId series, std::int64_t time_ns) {
    return state_->consistent([&] { return state_->before(series, time_ns, state_->logged(series)); });
}

Result<std::vector<HistoryGap>> HistoryReader::gaps(const HistoryRange& range) {
    return state_->consistent([&] {
        state_->note_recorded(range);
        return gaps_in(state_->gaps, range.from_ns, range.to_ns - 1);
    });
}

Result<void> HistoryReader::read(SeriesId series, const HistoryRange& range,
                                 const std::function<bool(const HistorySample&)>& sample) {
    const auto done = state_->consistent([&] {
        state_->note_recorded(range);
        const auto log = state_->logged(series);
        const auto rows = state_->chunks(series, range, log);
        for (Cluster left(rows); !left.empty();) {
            const Cluster cluster = next_cluster(left);
            left = left.subspan(cluster.size());
            for (const auto& entry : state_->merged(cluster, log)) {
                if (entry.time_ns < range.from_ns || entry.time_ns >= range.to_ns) continue;
                if (!sample(entry)) return false;
            }
        }
        return true;
    });
    if (!done) return std::unexpected(done.error());
    return {};
}

Result<HistoryPicture> HistoryReader::picture(SeriesId series, const HistoryRange& range,
                                              std::size_t pixels) {
    if (range.from_ns >= range.to_ns || pixels < 1 || pixels > kMostPixels)
        return fail(Code::out_of_range, static_cast<std::int64_t>(pixels), 1, kMostPixels);
    return state_->consistent([&] { return state_->picture(series, range, pixels); });
}

const std::vector<HistoryDamage>& HistoryReader::damage() const {
    return state_->damage;
}

}  // namespace takt::store
