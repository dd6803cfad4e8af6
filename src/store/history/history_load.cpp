#include "history/history_load.hpp"

#include <optional>
#include <set>
#include <utility>

#include "history/history_chunks.hpp"

namespace takt::store {
namespace {

void append(std::vector<HistoryDamage>& all, const std::vector<HistoryDamage>& more) {
    all.insert(all.end(), more.begin(), more.end());
}

/// What a repair needs.
struct Findings {
    std::vector<SeriesRow> rows;
    HistoryGaps known_gaps;
    std::set<SeriesId> incomplete;  // chunks of these variables are missing
    bool rollups = false;
    std::vector<ChunkRow> bad_open;
    bool gaps = false;
    bool series = false;
};

void load_chunks(SQLite::Database& database, const SeriesRow& series, const HistoryGaps& gaps,
                 OpenChunks& open, LoadedHistory& loaded, Findings& findings) {
    const auto chunks = read_chunks(database, series, gaps);
    append(loaded.damage, chunks.damage);
    if (!chunks.damage.empty()) findings.incomplete.insert(series.info.id);
    findings.rollups = findings.rollups || chunks.restored > 0 || !chunks.damage.empty();
    for (const ChunkRow& row : chunks.rows) {
        if (!row.open) continue;
        if (const auto samples = read_samples(database, row)) {
            open.load(row, *samples);
            continue;
        }
        loaded.damage.push_back(damage_of(row, series.info.series.name));
        findings.bad_open.push_back(row);
    }
}

void write_gaps(SQLite::Database& database, LoadedHistory& loaded, OpenChunks& open) {
    std::optional<HistoryGap> last;
    for (const auto& its : loaded.damage) {
        if (!its.first_ns || !its.last_ns) continue;
        const HistoryGap gap{*its.first_ns, *its.last_ns, GapCause::damaged, its.samples};
        if (gap == last) continue;  // neighbours in the log
        write_gap(database, loaded.state, gap);
        open.add(gap);
        last = gap;
    }
}

void repair(SQLite::Database& database, LoadedHistory& loaded, OpenChunks& open, const Findings& findings) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    if (findings.series) repair_series(database, findings.rows);
    if (findings.gaps) repair_gaps(database);
    if (findings.rollups) rebuild_rollups(database, findings.rows, findings.known_gaps);
    {
        ChunkWriter writer(database);
        for (const ChunkRow& row : findings.bad_open) writer.erase(row.series, row.summary.begin_ns, row.id);
        writer.finish(loaded.state);
    }
    write_gaps(database, loaded, open);
    open.fold(database, loaded.state, loaded.state.known_until_ns);
    count_rows(database, loaded.state, findings.incomplete);
    loaded.state.damaged = false;
    write_state(database, loaded.state);
    transaction.commit();
    static_cast<void>(open.folded());
}

}  // namespace

LoadedHistory load_history(SQLite::Database& database, OpenChunks& open) {
    LoadedHistory loaded;
    Findings findings;
    loaded.state = read_state(database);
    if (loaded.state.damaged) loaded.damage.push_back({.part = HistoryPart::state});
    findings.rows = read_series_rows(database);
    auto bad_series = damage_of(findings.rows, loaded.state);
    findings.series = !bad_series.empty();
    if (findings.series && restore_names(database, findings.rows))
        bad_series = damage_of(findings.rows, loaded.state);
    append(loaded.damage, bad_series);
    auto [gaps, bad_gaps] = read_gaps(database, loaded.state);
    findings.known_gaps = std::move(gaps);
    findings.gaps = !bad_gaps.empty();
    append(loaded.damage, bad_gaps);
    open.begin_at(last_chunk(database) + 1);
    for (const SeriesRow& row : findings.rows) {
        load_chunks(database, row, findings.known_gaps, open, loaded, findings);
        if (row.is_good()) loaded.series.push_back(row.info);
    }
    const auto log = read_log(database, loaded.state, newest_chunk_end(database));
    append(loaded.damage, log.damage);
    open.load(log);
    open.load(findings.known_gaps);
    if (!loaded.damage.empty() || findings.rollups || findings.series)
        repair(database, loaded, open, findings);
    return loaded;
}

}  // namespace takt::store
