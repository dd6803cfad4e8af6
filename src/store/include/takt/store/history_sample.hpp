// What a history keeps: samples of a series, and gaps.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "takt/base/data_type.hpp"
#include "takt/store/journal_record.hpp"
#include "takt/value/value.hpp"

namespace takt::store {

/// A variable whose values are kept.
struct HistorySeries {
    std::string name;  ///< unique; the key of the series
    std::string device;
    DataType type = DataType::int16;
    bool scaled = false;  ///< its values are doubles, whichever the type
    std::string unit;

    friend bool operator==(const HistorySeries&, const HistorySeries&) = default;
};

/// Number of a series in its file; stable.
struct SeriesId {
    std::uint32_t value = 0;
    friend constexpr auto operator<=>(SeriesId, SeriesId) = default;
};

/// Times are ns since 1970 UTC. They are kept in milliseconds, rounded down.
struct HistorySample {
    std::int64_t time_ns = 0;
    std::optional<std::int64_t> previous_ns;  ///< the poll before: the value changed after it
    value::Value value;
    value::Quality quality = value::Quality::good;
    value::Reason reason = value::Reason::ok;
};

/// Equal times, quality and reason, and value::same() values.
bool same(const HistorySample& a, const HistorySample& b);

/// Samples of all series that are missing.
struct HistoryGap {
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
    GapCause cause = GapCause::restart;
    std::uint64_t samples = 0;  ///< 0: unknown

    friend bool operator==(const HistoryGap&, const HistoryGap&) = default;
};

/// Place in the journal that the history was filled from.
struct HistoryPosition {
    std::uint64_t journal = 0;   ///< identity of the journal, chosen by the caller
    std::uint64_t sequence = 0;  ///< the last record that was appended

    friend bool operator==(const HistoryPosition&, const HistoryPosition&) = default;
};

}  // namespace takt::store
