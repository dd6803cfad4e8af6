#include "takt/base/histogram.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <vector>

namespace takt {
namespace histogram_test {

using namespace std::chrono_literals;

// Every order of magnitude gets its share.
rc::Gen<Duration> durations() {
    return rc::gen::map(
        rc::gen::pair(rc::gen::inRange(0, Histogram::kLimitBits), rc::gen::arbitrary<std::uint64_t>()),
        [](std::pair<int, std::uint64_t> v) {
            return Duration(static_cast<std::int64_t>(v.second >> (64 - Histogram::kLimitBits + v.first)));
        });
}

TEST(Histogram, BucketsCoverAllDurationsWithoutHoles) {
    const Histogram histogram;
    EXPECT_EQ(histogram.bucket(0).lower, 0ns);
    for (std::size_t i = 1; i < Histogram::kBuckets; ++i)
        ASSERT_EQ(histogram.bucket(i).lower, histogram.bucket(i - 1).upper + 1ns) << i;
    EXPECT_EQ(histogram.bucket(Histogram::kBuckets - 1).lower, Histogram::kLimit);
    EXPECT_EQ(histogram.bucket(Histogram::kBuckets - 1).upper, Duration::max());
}

TEST(Histogram, BucketsAreNarrow) {
    const Histogram histogram;
    for (std::size_t i = 0; i + 1 < Histogram::kBuckets; ++i) {
        const auto [lower, upper, count] = histogram.bucket(i);
        ASSERT_LE((upper - lower) * 128, lower) << i;
        ASSERT_TRUE(lower >= 256ns || upper == lower) << i;
    }
}

TEST(Histogram, ASampleCountsAsOftenAsItIsGiven) {
    Histogram once;
    Histogram often;
    for (int i = 0; i < 7; ++i) once.record(3ms);
    often.record(3ms, 7);
    EXPECT_EQ(often.count(), 7U);
    EXPECT_EQ(often.value_at_rank(7), once.value_at_rank(7));
    for (std::size_t i = 0; i < Histogram::kBuckets; ++i)
        ASSERT_EQ(often.bucket(i).count, once.bucket(i).count) << i;
}

TEST(Histogram, CountsEachSampleInTheBucketThatHoldsIt) {
    struct Case {
        Duration sample, counted_as;
    };
    constexpr Case kCases[] = {
        {-5ns, 0ns},
        {0ns, 0ns},
        {255ns, 255ns},
        {256ns, 256ns},
        {257ns, 257ns},
        {1ms, 1ms},
        {Histogram::kLimit - 1ns, Histogram::kLimit - 1ns},
        {Histogram::kLimit, Histogram::kLimit},
        {Duration::max(), Duration::max()},
    };
    for (const auto& [sample, counted_as] : kCases) {
        Histogram histogram;
        histogram.record(sample);
        for (std::size_t i = 0; i < Histogram::kBuckets; ++i) {
            const auto [lower, upper, count] = histogram.bucket(i);
            ASSERT_EQ(count, lower <= counted_as && counted_as <= upper ? 1U : 0U)
                << sample.count() << " in " << i;
        }
    }
}

RC_GTEST_PROP(Histogram, FindsTheBucketOfEveryRank, ()) {
    auto samples = *rc::gen::nonEmpty(rc::gen::container<std::vector<Duration>>(durations()));
    Histogram histogram;
    for (const Duration sample : samples) histogram.record(sample);
    std::sort(samples.begin(), samples.end());
    RC_ASSERT(histogram.count() == samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const Duration found = histogram.value_at_rank(i + 1);
        RC_ASSERT(found >= samples[i]);
        RC_ASSERT(found - samples[i] <= samples[i] / 128);
    }
}

TEST(HistogramDeathTest, HasNoRankBeyondItsSamples) {
    Histogram histogram;
    histogram.record(1ns);
    EXPECT_DEATH((void)histogram.value_at_rank(0), "");
    EXPECT_DEATH((void)histogram.value_at_rank(2), "");
}

}  // namespace histogram_test
}  // namespace takt
