// Statistics of the response times of one of many devices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "line/heap_optional.hpp"
#include "takt/base/latency_statistics.hpp"
#include "takt/poll/statistics.hpp"

namespace takt::poll {

/// The counts from the least bucket that has one to the greatest, in steps of kStep buckets. A count takes 32
/// bits; the higher 32 bits of all of them are kept once one of them needs them. add() allocates where the
/// bucket lies outside of them, and at the first count of 2^32.
template <std::size_t buckets>
class CountRange {
public:
    static constexpr std::size_t kStep = 8;

    void add(std::size_t bucket, std::uint64_t times);
    [[nodiscard]] std::uint64_t operator[](std::size_t bucket) const {
        if (bucket < first_ || bucket - first_ >= low_.size()) return 0;
        const std::uint64_t high = high_ ? (*high_)[bucket - first_] : 0;
        return high << 32 | low_[bucket - first_];
    }
    /// Of the counts, beside the object, as long as none needs more than 32 bits.
    [[nodiscard]] std::size_t allocated_bytes() const { return low_.capacity() * sizeof low_[0]; }

private:
    using Words = std::vector<std::uint32_t>;
    void include(std::size_t bucket);
    void resize(std::size_t before, std::size_t size);

    std::size_t first_ = 0;  // a multiple of kStep
    Words low_;
    HeapOptional<Words> high_;
};

/// Within 1/8 (12.5 %) from 1 us to 67 s. It takes 32 bytes for each power of two between the least and the
/// greatest sample.
using CompactHistogram = BasicHistogram<3, 26, 1000, CountRange>;
using CompactLatencyStatistics = BasicLatencyStatistics<CompactHistogram>;

/// The percentiles and the buckets with a count.
[[nodiscard]] HistogramSnapshot snapshot_of(const HeapOptional<CompactLatencyStatistics>& times);

}  // namespace takt::poll

namespace takt {

extern template class BasicHistogram<3, 26, 1000, poll::CountRange>;
extern template class BasicLatencyStatistics<poll::CompactHistogram>;

}  // namespace takt
