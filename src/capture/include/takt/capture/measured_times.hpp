// Statistics of many durations in little memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "takt/base/latency_statistics.hpp"

namespace takt::capture {

/// The counts of a histogram in blocks that are allocated when they are needed. Movable.
template <std::size_t buckets>
class BlockCounts {
public:
    void add(std::size_t bucket, std::uint64_t times) {
        auto& block = blocks_[bucket / kBlock];
        if (!block) block = std::make_unique<Block>();
        (*block)[bucket % kBlock] += times;
    }
    [[nodiscard]] std::uint64_t operator[](std::size_t bucket) const {
        const auto& block = blocks_[bucket / kBlock];
        return block ? (*block)[bucket % kBlock] : 0;
    }

private:
    static constexpr std::size_t kBlock = 128;
    using Block = std::array<std::uint64_t, kBlock>;
    std::array<std::unique_ptr<Block>, (buckets + kBlock - 1) / kBlock> blocks_;
};

/// As Histogram: within 1/128 (0.8 %) from 1 ns to 18 minutes. It takes 1 KiB for each power of two
/// that has a sample.
using BlockHistogram = BasicHistogram<7, 40, 1, BlockCounts>;
using BlockStatistics = BasicLatencyStatistics<BlockHistogram>;

/// Durations with count, minimum, mean and maximum, all exact. Percentiles are exact up to kExact samples;
/// beyond they are at most 0.8 % above the exact ones. Allocates. One owner, one thread.
class MeasuredTimes {
public:
    static constexpr std::size_t kExact = 1000;

    /// A negative duration counts as zero.
    void record(Duration sample);

    [[nodiscard]] std::uint64_t count() const { return statistics_.count(); }
    [[nodiscard]] Duration min() const { return statistics_.min(); }
    [[nodiscard]] Duration mean() const { return statistics_.mean(); }
    [[nodiscard]] Duration max() const { return statistics_.max(); }
    /// The nearest-rank percentile. @param percent  0..100
    [[nodiscard]] Duration percentile(double percent) const;
    [[nodiscard]] const BlockHistogram& histogram() const { return statistics_.histogram(); }

private:
    BlockStatistics statistics_;
    std::vector<Duration> few_;  // all samples, up to kExact
};

}  // namespace takt::capture

namespace takt {

extern template class BasicHistogram<7, 40, 1, capture::BlockCounts>;
extern template class BasicLatencyStatistics<capture::BlockHistogram>;

}  // namespace takt
