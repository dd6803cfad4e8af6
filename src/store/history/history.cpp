// A commit is one row of the log with all new samples, one sync. From time to time the log is folded: the
// samples move into chunks, one for each series, in a second transaction. If that fails, the log keeps them.
#include "takt/store/history.hpp"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "history/history_bytes.hpp"
#include "history/history_file.hpp"
#include "history/history_fold.hpp"
#include "history/history_load.hpp"
#include "history/history_log.hpp"
#include "history/history_loss.hpp"
#include "history/history_schema.hpp"
#include "history/history_tables.hpp"

namespace takt::store {
namespace {

constexpr std::int64_t kStateInterval = 10'000'000'000;  // ns: a commit without samples writes its time
constexpr std::size_t kDropBatch = 64;

std::int64_t in_unit(std::int64_t ns) {
    return nanoseconds(milliseconds(ns));
}

}  // namespace

struct History::State {
    State(HistoryFile opened, std::string its_path, const HistoryOptions& its_options)
        : file(std::move(opened)),
          path(std::move(its_path)),
          options(its_options),
          open(options.chunk_samples) {}

    /// @returns the damaged rows; gaps are in their place
    Result<std::vector<HistoryDamage>> load();
    Result<void> write(std::int64_t wall_ns);
    Result<void> fold(std::int64_t wall_ns);
    Result<void> drop(std::int64_t wall_ns);
    /// Ends the work with a file that is damaged.
    void replace_if_damaged(const Error& error);
    /// Runs `statements` as one transaction.
    template <class Statements>
    Result<void> transaction(Statements statements);

    HistoryFile file;
    std::string path;
    HistoryOptions options;
    OpenChunks open;
    std::vector<HistorySeriesInfo> all_series;
    HistoryState committed;
    std::optional<HistoryPosition> position;  // of what is appended now
    bool skipping = false;
    std::vector<LoggedSample> pending;
    std::vector<HistoryGap> pending_gaps;
    std::size_t log_bytes = 0;
    std::size_t log_commits = 0;
    HistoryStatus status;
    std::optional<Error> damaged;
};

template <class Statements>
Result<void> History::State::transaction(Statements statements) {
    return with_results(path, file.database.get(), [&]() -> Result<void> {
        SQLite::Transaction transaction(*file.database, SQLite::TransactionBehavior::IMMEDIATE);
        statements(*file.database);
        transaction.commit();
        return {};
    });
}

void History::State::replace_if_damaged(const Error& error) {
    if (error.code != Code::malformed) return;
    damaged = error;
    file.database.reset();
    if (auto replaced = replace_history(path, options.retention))
        status.set_aside = std::move(replaced->set_aside);
}

Result<std::vector<HistoryDamage>> History::State::load() {
    return with_results(path, file.database.get(), [&]() -> Result<std::vector<HistoryDamage>> {
        repair_indexes(*file.database);
        auto loaded = load_history(*file.database, open);
        committed = loaded.state;
        position = committed.position;
        all_series = std::move(loaded.series);
        log_commits = open.samples() > 0 ? options.log_commits : 0;  // fold what is there
        return std::move(loaded.damage);
    });
}

Result<void> History::State::write(std::int64_t wall_ns) {
    const bool idle = pending.empty() && pending_gaps.empty() && position == committed.position;
    if (idle && wall_ns - kStateInterval < committed.known_until_ns &&
        wall_ns + kStateInterval > committed.known_until_ns)
        return {};
    TAKT_CHECK(check_unmoved(*file.database, path));
    HistoryState next = committed;
    next.position = position;
    next.known_until_ns = wall_ns;
    const auto row = pending.empty() ? std::vector<std::uint8_t>() : encode_log(pending);
    TAKT_CHECK(transaction([&](SQLite::Database& database) {
        if (!row.empty()) write_log(database, next, row);
        for (const auto& gap : pending_gaps) write_gap(database, next, gap);
        write_state(database, next);
    }));
    committed = next;
    log_bytes += row.size();
    if (!row.empty()) ++log_commits;
    status.samples += pending.size();
    for (const auto& logged : pending) open.add(logged);
    for (const auto& gap : pending_gaps) open.add(gap);
    pending.clear();
    pending_gaps.clear();
    return {};
}

Result<void> History::State::fold(std::int64_t wall_ns) {
    if (log_bytes < options.log_bytes && log_commits < options.log_commits) return {};
    HistoryState next = committed;
    TAKT_CHECK(transaction([&](SQLite::Database& database) {
        open.fold(database, next, wall_ns);
        write_state(database, next);
    }));
    committed = next;
    status.chunks += open.folded();
    log_bytes = 0;
    log_commits = 0;
    return {};
}

// Batches until nothing is too old or the time is over. The rest follows with the next commits.
Result<void> History::State::drop(std::int64_t wall_ns) {
    const auto end = std::chrono::steady_clock::now() + options.drop_time;
    const std::int64_t oldest =
        options.retention > Duration::zero() ? wall_ns - options.retention.count() : INT64_MIN;
    HistoryPages pages;
    std::size_t dropped = kDropBatch;
    while (dropped == kDropBatch && std::chrono::steady_clock::now() < end) {
        TAKT_CHECK(with_results(path, file.database.get(), [&]() -> Result<void> {
            pages = pages_of(*file.database);
            return {};
        }));
        const bool too_large = options.quota_bytes > 0 && pages.used_bytes > options.quota_bytes;
        const std::int64_t cutoff = too_large ? INT64_MAX : oldest;
        HistoryState next = committed;
        TAKT_CHECK(transaction([&](SQLite::Database& database) {
            dropped = drop_chunks(database, next, cutoff, kDropBatch);
            if (dropped > 0 && oldest != INT64_MIN) drop_gaps(database, next, oldest);
            if (dropped > 0) write_state(database, next);
        }));
        committed = next;
        status.dropped += dropped;
    }
    status.used_bytes = pages.used_bytes;
    status.file_bytes = pages.file_bytes;
    return {};
}

History::History(std::unique_ptr<State> state) : state_(std::move(state)) {}
History::~History() = default;

Result<History::Opened> History::open(const std::string& path, const HistoryOptions& options) {
    Opened opened;
    const auto load = [&]() -> Result<std::unique_ptr<State>> {
        TAKT_TRY(HistoryFile file, open_history_file(path));
        auto state = std::make_unique<State>(std::move(file), path, options);
        TAKT_TRY(opened.damage, state->load());
        return state;
    };
    auto state = load();
    if (!state && state.error().code == Code::malformed) {
        {
            TAKT_TRY(auto replaced, replace_history(path, options.retention));
            opened.set_aside = std::move(replaced.set_aside);
        }
        state = load();
    }
    if (!state) return std::unexpected(state.error());
    opened.history = std::unique_ptr<History>(new History(std::move(*state)));
    return opened;
}

Result<SeriesId> History::series(const HistorySeries& properties) {
    State& s = *state_;
    if (s.damaged) return std::unexpected(*s.damaged);
    const auto known = std::ranges::find(s.all_series, properties.name,
                                         [](const auto& info) -> const auto& { return info.series.name; });
    if (known != s.all_series.end() && known->series == properties) return known->id;
    SeriesId id;
    HistoryState next = s.committed;
    const auto written = s.transaction([&](SQLite::Database& database) {
        id = write_series(database, next, properties);
        write_state(database, next);
    });
    if (!written) s.replace_if_damaged(written.error());
    TAKT_CHECK(written);
    s.committed = next;
    if (known != s.all_series.end())
        known->series = properties;
    else
        s.all_series.push_back({id, properties});
    return id;
}

void History::begin_record(const HistoryPosition& position) {
    State& s = *state_;
    const auto& last = s.position;
    s.skipping = last && last->journal == position.journal && position.sequence <= last->sequence;
    if (!s.skipping) s.position = position;
}

void History::append(SeriesId series, const HistorySample& sample) {
    State& s = *state_;
    if (s.skipping) {
        ++s.status.repeated;
        return;
    }
    LoggedSample& logged = s.pending.emplace_back(series, sample);
    logged.sample.time_ns = in_unit(sample.time_ns);
    if (sample.previous_ns) logged.sample.previous_ns = in_unit(*sample.previous_ns);
}

void History::append(const HistoryGap& gap) {
    State& s = *state_;
    if (!s.skipping) s.pending_gaps.push_back(gap);
}

Result<void> History::commit(std::int64_t wall_ns) {
    State& s = *state_;
    if (s.damaged) return std::unexpected(*s.damaged);
    auto done = s.write(wall_ns);
    s.status.failure.reset();
    if (done) {
        auto kept = s.fold(wall_ns);
        if (kept) kept = s.drop(wall_ns);
        if (!kept) s.status.failure = kept.error();
        if (!kept && kept.error().code == Code::malformed) done = kept;
    }
    if (!done) s.replace_if_damaged(done.error());
    return done;
}

std::optional<HistoryPosition> History::position() const {
    return state_->committed.position;
}

HistoryStatus History::status() const {
    HistoryStatus status = state_->status;
    status.pending = state_->pending.size();
    return status;
}

}  // namespace takt::store
