// The durable position of a destination, in two slots that are written in turn.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "journal/journal_segments.hpp"

namespace takt::store {

struct CursorState {
    static constexpr std::uint64_t kAllHandedOut = std::numeric_limits<std::uint64_t>::max();

    StreamPosition position;      ///< end of the last acknowledged entry
    std::uint64_t delivered = 0;  ///< samples, since the destination was created
    std::uint64_t dropped = 0;    ///< samples in acknowledged gaps
    std::uint64_t gaps = 0;       ///< acknowledged ones with samples
    /// The last sequence number that the destination may have read; kAllHandedOut: any of the stream.
    std::uint64_t handed_out = 0;
    StreamPosition quota_end;  ///< see SegmentList

    friend bool operator==(const CursorState&, const CursorState&) = default;
};

/// A slot is overwritten only after a successful sync of the other one, which has the higher counter then.
class JournalCursor {
public:
    enum class Found : std::uint8_t {
        nothing,  ///< there is no cursor file
        damaged,  ///< neither slot is good
        state,
    };

    JournalCursor(JournalStorage& storage, std::string name) : storage_(&storage), name_(std::move(name)) {}

    /// @returns the errors of the storage
    [[nodiscard]] Result<Found> load();
    /// Writes `state` into the older slot. After an error the same slot is used again.
    Result<void> save(const CursorState& state);

    [[nodiscard]] const std::string& name() const { return name_; }
    /// The state that survives a power cut.
    [[nodiscard]] const CursorState& durable() const { return durable_; }

private:
    JournalStorage* storage_;
    std::string name_;
    CursorState durable_;
    std::uint64_t counter_ = 0;
    unsigned next_slot_ = 0;
};

}  // namespace takt::store
