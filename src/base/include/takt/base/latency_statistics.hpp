// Statistics of a series of measured times.
#pragma once

#include <cstdint>

#include "takt/base/histogram.hpp"

namespace takt {

/// Count, least, mean and greatest of a series of durations, all exact, and its percentiles as precise as the
/// histogram H is.
///
/// Negative durations count as zero. The mean is exact while the sum of all samples stays below 584 years.
/// Without samples every duration is zero. Allocates where H does. One owner, one thread.
/// latency_statistics_definitions.hpp has the member functions.
template <class H>
class BasicLatencyStatistics {
public:
    /// @param times  how often
    void record(Duration sample, std::uint64_t times = 1);

    /// Adds the other's samples, as if they had been recorded here.
    void merge(const BasicLatencyStatistics& other);

    [[nodiscard]] std::uint64_t count() const { return histogram_.count(); }
    [[nodiscard]] Duration min() const { return min_; }
    [[nodiscard]] Duration max() const { return max_; }
    /// Rounded down to a nanosecond.
    [[nodiscard]] Duration mean() const;

    /// The nearest-rank percentile: at least `percent` % of the samples are not greater than the result. The
    /// result is never below the exact percentile, above it by at most the width of a bucket (below
    /// H::kLimit), and never above max().
    /// @param percent  0..100, clamped. 0 is min(), 100 is max()
    [[nodiscard]] Duration percentile(double percent) const;

    [[nodiscard]] const H& histogram() const { return histogram_; }

private:
    void add_to_sum(std::uint64_t nanoseconds, std::uint64_t times);

    H histogram_;
    Duration min_{};
    Duration max_{};
    std::uint64_t sum_ = 0;
};

using LatencyStatistics = BasicLatencyStatistics<Histogram>;

extern template class BasicLatencyStatistics<Histogram>;

}  // namespace takt
