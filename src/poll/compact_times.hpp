// Statistics of the response times of one of many devices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/timing/latency_statistics.hpp"

namespace takt::poll {

/// The counts from the least bucket that has one to the greatest, in steps of kStep buckets. add() allocates
/// where the bucket lies outside of them.
template <std::size_t buckets>
class CountRange {
public:
    static constexpr std::size_t kStep = 8;

    void add(std::size_t bucket, std::uint64_t times);
    [[nodiscard]] std::uint64_t operator[](std::size_t bucket) const {
        return bucket >= first_ && bucket - first_ < counts_.size() ? counts_[bucket - first_] : 0;
    }
    /// Of the counts, beside the object.
    [[nodiscard]] std::size_t allocated_bytes() const { return counts_.capacity() * sizeof counts_[0]; }

private:
    std::size_t first_ = 0;  // a multiple of kStep
    std::vector<std::uint64_t> counts_;
};

/// Within 1/8 (12.5 %) from 1 us to 67 s. It takes 64 bytes for each power of two between the least and the
/// greatest sample.
using CompactHistogram = timing::BasicHistogram<3, 26, 1000, CountRange>;
using CompactLatencyStatistics = timing::BasicLatencyStatistics<CompactHistogram>;

}  // namespace takt::poll

namespace takt::timing {

extern template class BasicHistogram<3, 26, 1000, poll::CountRange>;
extern template class BasicLatencyStatistics<poll::CompactHistogram>;

}  // namespace takt::timing
