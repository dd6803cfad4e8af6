#include "takt/base/latency_statistics.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace takt {
namespace latency_statistics_test {

using namespace std::chrono_literals;

constexpr double kPercents[] = {0, 0.1, 1, 25, 50, 90, 99, 99.9, 99.99, 100};

std::vector<Duration> some_samples(std::int64_t greatest) {
    return *rc::gen::map(
        rc::gen::container<std::vector<std::int64_t>>(rc::gen::inRange<std::int64_t>(0, greatest)),
        [](const std::vector<std::int64_t>& numbers) {
            return std::vector<Duration>(numbers.begin(), numbers.end());
        });
}

LatencyStatistics of(const std::vector<Duration>& samples) {
    LatencyStatistics statistics;
    for (const Duration sample : samples) statistics.record(sample);
    return statistics;
}

Duration exact_percentile(const std::vector<Duration>& sorted, double percent) {
    const auto rank = static_cast<std::size_t>(std::ceil(percent * static_cast<double>(sorted.size()) / 100));
    return sorted[std::max<std::size_t>(rank, 1) - 1];
}

// docs/specification.md, section 10: the five exchanges of [D]
TEST(LatencyStatistics, DescribesTheMeasuredExchanges) {
    const auto statistics = of({205us, 146us, 148us, 152us, 149us});
    EXPECT_EQ(statistics.count(), 5U);
    EXPECT_EQ(statistics.min(), 146us);
    EXPECT_EQ(statistics.max(), 205us);
    EXPECT_EQ(statistics.mean(), 160us);  // 800 / 5
    EXPECT_GE(statistics.percentile(50), 149us);
    EXPECT_LT(statistics.percentile(50), 151us);
    EXPECT_EQ(statistics.percentile(99), 205us);
}

TEST(LatencyStatistics, ASampleCountsAsOftenAsItIsGiven) {
    LatencyStatistics statistics;
    statistics.record(2ms, 999);
    statistics.record(7ms, 1);
    statistics.record(9ms, 0);
    EXPECT_EQ(statistics.count(), 1000U);
    EXPECT_EQ(statistics.mean(), 2005us);
    EXPECT_EQ(statistics.max(), 7ms);
    EXPECT_GE(statistics.percentile(99.9), 2ms);
    EXPECT_LE(statistics.percentile(99.9), 2250us);
    statistics.record(Duration::max(), std::uint64_t{1} << 40);
    EXPECT_GT(statistics.mean(), 7ms) << "a sum that is too large saturates";
}

TEST(LatencyStatistics, IsZeroWithoutSamples) {
    const LatencyStatistics statistics;
    EXPECT_EQ(statistics.count(), 0U);
    EXPECT_EQ(statistics.mean(), 0ns);
    for (const double percent : kPercents) EXPECT_EQ(statistics.percentile(percent), 0ns);
}

TEST(LatencyStatistics, TakesPercentsOutsideTheirRangeAsItsEnds) {
    const auto statistics = of({1ms, 2ms});
    EXPECT_EQ(statistics.percentile(-1), 1ms);
    EXPECT_EQ(statistics.percentile(std::nan("")), 1ms);
    EXPECT_EQ(statistics.percentile(1000), 2ms);
}

TEST(LatencyStatistics, StaysInBoundsWithExtremeSamples) {
    const auto statistics = of({Duration::max(), Duration::max(), Duration::max(), Duration::min()});
    EXPECT_EQ(statistics.min(), 0ns) << "negative counts as zero";
    EXPECT_EQ(statistics.max(), Duration::max());
    EXPECT_GT(statistics.mean(), 0ns);
    EXPECT_LE(statistics.mean(), Duration::max());
    EXPECT_EQ(statistics.percentile(50), Duration::max());
}

RC_GTEST_PROP(LatencyStatistics, AgreesWithTheSortedSamples, ()) {
    auto samples =
        some_samples(*rc::gen::elementOf(std::vector<std::int64_t>{3, 1'000, 1'000'000, 1'000'000'000'000}));
    RC_PRE(!samples.empty());
    const auto statistics = of(samples);
    std::sort(samples.begin(), samples.end());
    RC_ASSERT(statistics.count() == samples.size());
    RC_ASSERT(statistics.min() == samples.front());
    RC_ASSERT(statistics.max() == samples.back());
    const auto sum = std::accumulate(samples.begin(), samples.end(), Duration::zero());
    RC_ASSERT(statistics.mean() == sum / static_cast<std::int64_t>(samples.size()));
    for (const double percent : kPercents) {
        const Duration exact = exact_percentile(samples, percent);
        RC_ASSERT(statistics.percentile(percent) >= exact);
        RC_ASSERT(statistics.percentile(percent) - exact <= exact / 128);
        RC_ASSERT(statistics.percentile(percent) <= samples.back());
    }
}

RC_GTEST_PROP(LatencyStatistics, MergesAsIfRecordedTogether, ()) {
    const auto first = some_samples(1'000'000'000);
    const auto second = some_samples(1'000'000'000);
    auto together = first;
    together.insert(together.end(), second.begin(), second.end());
    auto merged = of(first);
    merged.merge(of(second));
    const auto expected = of(together);
    RC_ASSERT(merged.count() == expected.count());
    RC_ASSERT(merged.min() == expected.min());
    RC_ASSERT(merged.max() == expected.max());
    RC_ASSERT(merged.mean() == expected.mean());
    for (const double percent : kPercents)
        RC_ASSERT(merged.percentile(percent) == expected.percentile(percent));
}

}  // namespace latency_statistics_test
}  // namespace takt
