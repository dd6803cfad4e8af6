// Samples of one series as bytes: the chunks of a history.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/store/history_sample.hpp"

namespace takt::store {

struct HistoryCodecOptions {
    std::int64_t unit_ns = 1'000'000;  ///< times are multiples of it; > 0
    bool compress = true;              ///< zstd, where it saves bytes
};

/// Encodes samples in the order given. Times are rounded down to the unit. Any order of times, any mixture of
/// values, qualities and reasons is exact.
[[nodiscard]] std::vector<std::uint8_t> encode_history(std::span<const HistorySample> samples,
                                                       const HistoryCodecOptions& options = {});

/// @returns malformed: the bytes are not those that encode_history() returned
[[nodiscard]] Result<std::vector<HistorySample>> decode_history(Bytes bytes);

}  // namespace takt::store
