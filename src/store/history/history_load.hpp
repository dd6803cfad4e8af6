// What a writer does first: it checks all rows but the bytes of closed chunks, and repairs.
#pragma once

#include <string>
#include <vector>

#include "history/history_fold.hpp"
#include "history/history_tables.hpp"
#include "registers/database.hpp"

namespace takt::store {

struct LoadedHistory {
    HistoryState state;
    std::vector<HistorySeriesInfo> series;  ///< without damaged rows
    std::vector<HistoryDamage> damage;
};

/// Reads state, variables, open chunks and the log. If something is damaged, one transaction recomputes
/// roll-ups, writes gaps `damaged` in the place of samples, removes the damaged rows of log and gaps, folds,
/// and sets digests: so a second call does not find the same damage. A damaged row of a variable stays, and
/// so does the digest of a variable with a roll-up that cannot be recomputed: readers report them.
/// @throws SQLite::Exception
[[nodiscard]] LoadedHistory load_history(SQLite::Database& database, OpenChunks& open);

}  // namespace takt::store
