// Statistics of a series of measured times.
#pragma once

#include <cstdint>

#include "takt/timing/histogram.hpp"

namespace takt::timing {

/// Count, least, mean and greatest of a series of durations, all exact, and its percentiles within 1/128.
///
/// Negative durations count as zero. The mean is exact while the sum of all samples stays below 584 years.
/// Without samples every duration is zero. Fixed size, never allocates. One owner, one thread.
class LatencyStatistics {
public:
    void record(Duration sample);

    /// Adds the other's samples, as if they had been recorded here.
    void merge(const LatencyStatistics& other);

    [[nodiscard]] std::uint64_t count() const { return histogram_.count(); }
    [[nodiscard]] Duration min() const { return min_; }
    [[nodiscard]] Duration max() const { return max_; }
    /// Rounded down to a nanosecond.
    [[nodiscard]] Duration mean() const;

    /// The nearest-rank percentile: at least `percent` % of the samples are not greater than the result. The
    /// result is never below the exact percentile, at most 1/128 above it (below Histogram::kLimit), and
    /// never above max().
    /// @param percent  0..100, clamped. 0 is min(), 100 is max()
    [[nodiscard]] Duration percentile(double percent) const;

    [[nodiscard]] const Histogram& histogram() const { return histogram_; }

private:
    void add_to_sum(std::uint64_t nanoseconds);

    Histogram histogram_;
    Duration min_{};
    Duration max_{};
    std::uint64_t sum_ = 0;
};

}  // namespace takt::timing
