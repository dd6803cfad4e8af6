// Committed samples that are in no chunk yet, of all series in the order of their arrival: rows of the log.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/store/history_damage.hpp"
#include "takt/store/history_sample.hpp"

namespace takt::store {

struct LoggedSample {
    SeriesId series;
    HistorySample sample;
};

/// Times are rounded down to milliseconds. The bytes end with a checksum.
[[nodiscard]] std::vector<std::uint8_t> encode_log(std::span<const LoggedSample> samples);
/// @returns malformed
[[nodiscard]] Result<std::vector<LoggedSample>> decode_log(Bytes bytes);

/// A row of the log. Its number is 1 for the first row after a fold, and one more for each further row.
struct LogRow {
    std::int64_t id = 0;
    std::vector<std::uint8_t> data;
};

struct DecodedLog {
    std::vector<LoggedSample> samples;  ///< in the order of arrival
    std::vector<HistoryDamage> damage;  ///< rows whose samples are left out
};

/// The times of a damaged row lie between those of its neighbours, as long as the clock is not set back.
/// @param rows     in the order of their numbers
/// @param from_ns  a time before the first row
/// @param to_ns    a time after the last row
[[nodiscard]] DecodedLog decode_log(std::span<const LogRow> rows, std::int64_t from_ns, std::int64_t to_ns);

}  // namespace takt::store
