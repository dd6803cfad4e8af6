// Committed samples that are in no chunk yet, of all series in the order of their arrival: rows of the log.
#pragma once

#include <span>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
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

}  // namespace takt::store
