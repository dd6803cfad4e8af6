// What a destination or a replay reads from the journal.
#pragma once

#include <optional>

#include "takt/base/result.hpp"
#include "takt/store/journal_record.hpp"

namespace takt::store {

/// A record of the stream, or a gap.
struct JournalEntry {
    RecordHeader header;     ///< of a gap that was found while reading: sequence is Gap::last_sequence
    Bytes payload;           ///< empty for a gap; valid until the next read of the same reader
    std::optional<Gap> gap;  ///< samples are missing here
    /// It was handed out before in this run, or perhaps in an earlier one: after a kill while a destination
    /// was reading, all records of that run count as handed out.
    bool repeated = false;
};

/// Durable records in their order. Each sequence number is in one entry: a record, or a gap that covers it.
class JournalStream {
public:
    virtual ~JournalStream() = default;

    /// @returns none: everything that is durable was read; io_failed: call again later
    [[nodiscard]] virtual Result<std::optional<JournalEntry>> next() = 0;
};

}  // namespace takt::store
