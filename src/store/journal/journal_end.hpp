// The end of the stream as the last run knew it, in a small file beside the cursors.
#pragma once

#include <cstdint>
#include <optional>

#include "journal/journal_segments.hpp"

namespace takt::store {

struct JournalEnd {
    StreamPosition durable;          ///< of the last durable record
    std::uint64_t samples = 0;       ///< of the stream; more than those of `durable` were in memory only
    GapCause cause{};                ///< why they were not durable
    std::int64_t first_wall_ns = 0;  ///< of the oldest sample in memory
    std::int64_t last_wall_ns = 0;   ///< of the newest one

    friend bool operator==(const JournalEnd&, const JournalEnd&) = default;
};

/// Two slots, written in turn without a sync: a killed process loses nothing of them. After a power cut the
/// end may be an older one, or unknown. An older one is never wrong: the segments show what became durable
/// later.
class JournalEndFile {
public:
    explicit JournalEndFile(JournalStorage& storage) : storage_(&storage) {}

    /// @returns none: there is no good slot; the errors of the storage
    [[nodiscard]] Result<std::optional<JournalEnd>> load();
    /// No effect if `end` is what was written last. Both slots are written the first time: they have their
    /// place then when the disk is full.
    Result<void> write(const JournalEnd& end);
    Result<void> sync() { return storage_->sync_end(); }

private:
    JournalStorage* storage_;
    std::optional<JournalEnd> written_;
    std::uint64_t counter_ = 0;
};

}  // namespace takt::store
