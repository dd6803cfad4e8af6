// A histogram of durations with buckets of bounded relative width.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/time.hpp"

namespace takt::timing {

/// A log-linear histogram as in HdrHistogram: each octave is divided into 128 buckets of equal width.
///
/// A bucket's upper bound is at most 1/128 (0.8 %) above any duration in it. Below 256 ns every nanosecond
/// has its own bucket. Negative durations count as zero. Durations of kLimit and more share the last bucket,
/// for which the bound does not hold. Fixed size (about 35 KiB), never allocates. One owner, one thread.
class Histogram {
public:
    static constexpr int kPrecisionBits = 7;
    static constexpr int kLimitBits = 40;
    static constexpr Duration kLimit{std::int64_t{1} << kLimitBits};  ///< about 18 minutes
    static constexpr std::size_t kBuckets =
        (std::size_t{kLimitBits - kPrecisionBits} << kPrecisionBits) + (std::size_t{1} << kPrecisionBits) + 1;

    /// Durations `lower`..`upper`, inclusive; the last bucket's upper bound is Duration::max().
    struct Bucket {
        Duration lower{};
        Duration upper{};
        std::uint64_t count = 0;
    };

    void record(Duration sample);

    /// Adds the other's counts, as if its samples had been recorded here.
    void merge(const Histogram& other);

    [[nodiscard]] std::uint64_t count() const { return total_; }

    /// The upper bound of the bucket that holds the sample of that rank.
    /// @param rank  1 for the least sample up to count() for the greatest
    [[nodiscard]] Duration value_at_rank(std::uint64_t rank) const;

    /// @param index  0..kBuckets - 1, by ascending durations
    [[nodiscard]] Bucket bucket(std::size_t index) const;

private:
    std::array<std::uint64_t, kBuckets> counts_{};
    std::uint64_t total_ = 0;
};

}  // namespace takt::timing
