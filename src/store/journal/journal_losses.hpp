// The samples of the stream that are known to be missing, and the search for them after a start.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "journal/journal_reader.hpp"

namespace takt::store {

/// Missing samples as ranges of their numbers in the stream: gaps that were written, records that the quota
/// removed, damage that was found. Memory is bounded: if there are very many gaps, later ones are unknown
/// here until a destination reads them.
class KnownLosses {
public:
    /// Adds the `samples` after the first `before` of the stream. What is known already is not added twice.
    void add(std::uint64_t before, std::uint64_t samples, GapCause cause);
    /// Forgets ranges that end in the first `samples` of the stream.
    void forget(std::uint64_t samples);

    struct Sum {
        std::uint64_t samples = 0;
        std::uint64_t gaps = 0;
    };
    /// What is missing after the first `samples` of the stream.
    [[nodiscard]] Sum after(std::uint64_t samples) const;

private:
    static constexpr std::size_t kMostRanges = 50'000;  // 4 MB

    struct Range {
        std::uint64_t end = 0;
        GapCause cause{};
    };
    std::map<std::uint64_t, Range> ranges_;  // by their begin; disjoint
    std::uint64_t samples_ = 0;              // in all of them
};

/// Reads what waits, in small steps, and adds the gaps in it to the known losses.
class LossSurvey {
public:
    /// All must outlive the survey.
    LossSurvey(const SegmentList& segments, JournalStorage& storage, KnownLosses& losses)
        : segments_(&segments), storage_(&storage), losses_(&losses) {}

    /// Goes to `start`. The survey ends with the record that is the last durable one now.
    void begin(const StreamPosition& start);
    [[nodiscard]] bool done() const { return !reader_; }
    /// Reads about 256 KB. @returns the errors of the storage: try again later
    Result<void> step();

private:
    const SegmentList* segments_;
    JournalStorage* storage_;
    KnownLosses* losses_;
    std::optional<JournalReader> reader_;
    std::uint64_t last_ = 0;  // sequence number
};

}  // namespace takt::store
