#include "devices/compact_times.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace takt::poll {
namespace compact_times_test {

using namespace std::chrono_literals;

// Every order of magnitude gets its share.
rc::Gen<Duration> durations() {
    return rc::gen::map(
        rc::gen::pair(rc::gen::inRange(0, Histogram::kLimitBits), rc::gen::arbitrary<std::uint64_t>()),
        [](std::pair<int, std::uint64_t> v) {
            return Duration(static_cast<std::int64_t>(v.second >> (64 - Histogram::kLimitBits + v.first)));
        });
}

TEST(CompactHistogram, CoversAllDurationsInNarrowBuckets) {
    const CompactHistogram histogram;
    EXPECT_EQ(histogram.bucket(0).lower, 0ns);
    for (std::size_t i = 1; i < CompactHistogram::kBuckets; ++i)
        ASSERT_EQ(histogram.bucket(i).lower, histogram.bucket(i - 1).upper + 1ns) << i;
    EXPECT_EQ(histogram.bucket(CompactHistogram::kBuckets - 1).lower, CompactHistogram::kLimit);
    for (std::size_t i = 0; i + 1 < CompactHistogram::kBuckets; ++i) {
        const auto [lower, upper, count] = histogram.bucket(i);
        ASSERT_TRUE((upper - lower) * 8 <= lower || upper - lower < 1us) << i;
    }
}

TEST(CompactHistogram, IsSmall) {
    EXPECT_LE(sizeof(CompactHistogram), std::size_t{48});
    constexpr std::size_t kOctave = 32;
    CountRange<CompactHistogram::kBuckets> counts;
    EXPECT_EQ(counts.allocated_bytes(), 0U);
    counts.add(100, 1);
    counts.add(103, 1);
    EXPECT_EQ(counts.allocated_bytes(), kOctave);
    counts.add(104, 1);
    counts.add(95, 1);
    EXPECT_EQ(counts.allocated_bytes(), 3 * kOctave);
}

TEST(CompactHistogram, CountsBeyond32Bits) {
    CountRange<CompactHistogram::kBuckets> counts;
    constexpr std::uint64_t kMost = 0xFFFFFFFF;
    counts.add(100, kMost);
    counts.add(101, 5);
    counts.add(100, 2);
    EXPECT_EQ(counts[100], kMost + 2);
    counts.add(90, 3 * kMost);
    counts.add(120, 1);
    const auto copy = counts;
    EXPECT_EQ(copy[90], 3 * kMost);
    EXPECT_EQ(copy[100], kMost + 2);
    EXPECT_EQ(copy[101], 5U);
    EXPECT_EQ(copy[120], 1U);
    EXPECT_EQ(copy[121], 0U);
}

TEST(CompactLatencyStatistics, AreCopiedToAFixedSize) {
    EXPECT_EQ(snapshot_of({}).count, 0U);
    HeapOptional times(CompactLatencyStatistics{});
    EXPECT_TRUE(snapshot_of(times).buckets.empty());
    for (int i = 1; i <= 100; ++i) times->record(i * 1ms);
    const auto copy = snapshot_of(times);
    EXPECT_EQ(copy.count, 100U);
    EXPECT_EQ(copy.longest, 100ms);
    EXPECT_NEAR(static_cast<double>(copy.p50.count()), 50e6, 50e6 / 8);
    EXPECT_NEAR(static_cast<double>(copy.p99.count()), 99e6, 99e6 / 8);
    EXPECT_EQ(copy.buckets.back().upper_us, 100'000U);
    for (int bits = 0; bits < 40; ++bits)
        for (std::int64_t part = 8; part < 16; ++part) times->record(Duration(part << bits));
    const auto full = snapshot_of(times);
    EXPECT_EQ(full.buckets.size(), full.buckets.capacity());
    std::uint64_t count = 0;
    for (const auto& bucket : full.buckets) count += bucket.count;
    EXPECT_EQ(count, 420U);
    EXPECT_EQ(full.buckets.back().upper_us, UINT32_MAX);
}

TEST(CompactLatencyStatistics, TakeLittleMemoryForEachRequest) {
    EXPECT_LE(sizeof(CompactLatencyStatistics), std::size_t{72});
}

RC_GTEST_PROP(CompactHistogram, CountsEachSampleInItsBucket, ()) {
    const auto samples = *rc::gen::container<std::vector<Duration>>(durations());
    const auto others = *rc::gen::container<std::vector<Duration>>(durations());
    CompactHistogram histogram;
    CompactHistogram other;
    for (const Duration sample : samples) histogram.record(sample * 60);
    for (const Duration sample : others) other.record(sample * 60);
    histogram.merge(other);
    RC_ASSERT(histogram.count() == samples.size() + others.size());
    for (std::size_t i = 0; i < CompactHistogram::kBuckets; ++i) {
        const auto [lower, upper, count] = histogram.bucket(i);
        const auto inside = [&](Duration sample) { return lower <= sample * 60 && sample * 60 <= upper; };
        RC_ASSERT(count == static_cast<std::uint64_t>(std::ranges::count_if(samples, inside) +
                                                      std::ranges::count_if(others, inside)));
    }
}

}  // namespace compact_times_test
}  // namespace takt::poll
