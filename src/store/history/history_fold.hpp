// Moves committed samples from the log into chunks.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "history/history_chunks.hpp"
#include "history/history_log.hpp"
#include "history/history_tables.hpp"

namespace takt::store {

/// The samples of all series that are in no closed chunk. The file has them as open chunks and as the log.
class OpenChunks {
public:
    explicit OpenChunks(std::size_t chunk_samples) : chunk_samples_(chunk_samples) {}

    /// Takes the samples of the log, and of an open chunk.
    void load(const DecodedLog& log);
    void load(const ChunkRow& row, const std::vector<HistorySample>& samples);
    /// Of the whole file, by their first times; after the samples.
    void load(const HistoryGaps& gaps);
    /// The number of the next chunk.
    void begin_at(std::int64_t id) { next_id_ = id; }
    void add(const LoggedSample& logged);
    void add(const HistoryGap& gap);

    /// Writes all samples to chunks and clears the log, within the transaction of the caller. A chunk is
    /// closed when it is full, and when its hour is over at `wall_ns`. The caller writes the state.
    void fold(SQLite::Database& database, HistoryState& state, std::int64_t wall_ns);
    /// The transaction of the last fold() was committed. Without this call fold() begins again.
    /// @returns chunks that were closed
    std::size_t folded();

    [[nodiscard]] std::size_t samples() const { return samples_; }

private:
    struct Row {
        std::int64_t id = 0;
        std::int64_t begin_ns = 0;
    };
    struct Entry {
        std::vector<HistorySample> samples;
        bool changed = false;    // since the last fold
        std::optional<Row> row;  // the open chunk in the file
        // After fold(), before folded():
        std::size_t closed = 0;  // samples that closed chunks have
        std::optional<Row> next_row;
    };

    void fold(ChunkWriter& writer, SeriesId series, Entry& entry, std::int64_t wall_ns);

    std::size_t chunk_samples_;
    std::vector<Entry> entries_;  // by number of the series
    HistoryGaps gaps_;            // of the time of open chunks, by their first times
    std::size_t samples_ = 0;
    std::size_t closed_ = 0;
    std::int64_t next_id_ = 1;
    bool close_all_ = false;
};

}  // namespace takt::store
