// Roll-ups: what a picture needs of consecutive samples.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "takt/store/history_reader.hpp"
#include "takt/store/history_sample.hpp"

namespace takt::store {

inline constexpr double kNanosecondsPerSecond = 1e9;

/// The number of a sample that is drawn: of quality good or uncertain, finite, no text.
std::optional<double> drawn_number(const HistorySample& sample);

/// Consecutive samples in order of time. A value holds until the next sample or gap.
struct HistorySummary {
    std::int64_t begin_ns = 0;  ///< of the first and the last sample
    std::int64_t end_ns = 0;
    std::uint64_t samples = 0;
    value::Quality quality = value::Quality::good;  ///< of the first sample
    value::Reason reason = value::Reason::ok;       ///< of the first sample
    bool mixed = false;                             ///< not all have this quality and reason
    bool ends_good = false;                         ///< the quality of the last sample
    std::uint64_t numbers = 0;                      ///< samples with a drawn number
    HistoryPoint first{};                           ///< of the drawn numbers, if there are any
    HistoryPoint min{};
    HistoryPoint max{};
    HistoryPoint last{};
    bool ends_with_number = false;  ///< the last sample has a drawn number, which is `last`
    double area = 0;                ///< value times seconds, from the first to the last sample
    double drawn_s = 0;             ///< the time in which a number holds
    double good_s = 0;              ///< the time of quality good
};

/// Gaps in order of their first times.
using HistoryGaps = std::vector<HistoryGap>;

/// When the value of a sample at `from` ends to hold: at the begin of a gap, or at `to`.
std::int64_t hold_end(std::int64_t from_ns, std::int64_t to_ns, std::span<const HistoryGap> gaps);

HistorySummary summary_of(const HistorySample& sample);
/// Adds what follows; `next` does not begin before `summary` ends.
void append(HistorySummary& summary, const HistorySummary& next, std::span<const HistoryGap> gaps);
/// @param samples  at least one, in order of time
HistorySummary summary_of(std::span<const HistorySample> samples, std::span<const HistoryGap> gaps);

}  // namespace takt::store
