// Histograms of durations with buckets of bounded relative width.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/time.hpp"

namespace takt {

/// The counts of all buckets. Fixed size, never allocates.
template <std::size_t buckets>
class FixedCounts {
public:
    void add(std::size_t bucket, std::uint64_t times) { counts_[bucket] += times; }
    [[nodiscard]] std::uint64_t operator[](std::size_t bucket) const { return counts_[bucket]; }

private:
    std::array<std::uint64_t, buckets> counts_{};
};

/// A log-linear histogram as in HdrHistogram: each octave is divided into 2^precision_bits buckets of equal
/// width, from a unit of `unit_ns` up.
///
/// A bucket's upper bound is at most 1/2^precision_bits above any duration in it. Below 2^(precision_bits +
/// 1) units every unit has its own bucket. Negative durations count as zero. Durations of kLimit and more
/// share the last bucket, for which the bound does not hold. Only record() and merge() allocate, where Counts
/// does. One owner, one thread.
///
/// Counts: FixedCounts, or another class with add() and operator[]. histogram_definitions.hpp has the member
/// functions, for a source file that instantiates it.
template <int precision_bits, int limit_bits, std::int64_t unit_ns, template <std::size_t> class Counts>
class BasicHistogram {
public:
    static constexpr int kPrecisionBits = precision_bits;
    static constexpr int kLimitBits = limit_bits;
    static constexpr Duration kLimit{(std::int64_t{1} << limit_bits) * unit_ns};
    static constexpr std::size_t kBuckets =
        (std::size_t{limit_bits - precision_bits} << precision_bits) + (std::size_t{1} << precision_bits) + 1;

    /// Durations `lower`..`upper`, inclusive; the last bucket's upper bound is Duration::max().
    struct Bucket {
        Duration lower{};
        Duration upper{};
        std::uint64_t count = 0;
    };

    /// @param times  how often
    void record(Duration sample, std::uint64_t times = 1);

    /// Adds the other's counts, as if its samples had been recorded here.
    void merge(const BasicHistogram& other);

    [[nodiscard]] std::uint64_t count() const { return total_; }

    /// The upper bound of the bucket that holds the sample of that rank.
    /// @param rank  1 for the least sample up to count() for the greatest
    [[nodiscard]] Duration value_at_rank(std::uint64_t rank) const;

    /// @param index  0..kBuckets - 1, by ascending durations
    [[nodiscard]] Bucket bucket(std::size_t index) const;

private:
    Counts<kBuckets> counts_;
    std::uint64_t total_ = 0;
};

/// Within 1/128 (0.8 %) from 1 ns to 18 minutes; about 35 KiB.
using Histogram = BasicHistogram<7, 40, 1, FixedCounts>;

extern template class BasicHistogram<7, 40, 1, FixedCounts>;

}  // namespace takt
