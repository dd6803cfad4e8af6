#include "takt/capture/bound.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace takt::capture {
namespace bound_test {

TEST(Bound, RuleOfThree) {
    EXPECT_DOUBLE_EQ(upper_bound(0, 99'000), 3.0 / 99'000);
    EXPECT_EQ(one_in(upper_bound(0, 99'000)), 33'000u);
    EXPECT_EQ(one_in(upper_bound(0, 100'000)), 33'000u);
    EXPECT_EQ(one_in(upper_bound(0, 3'000'000'000)), 1'000'000'000u);
}

TEST(Bound, FewTrialsAreExact) {
    EXPECT_NEAR(upper_bound(0, 5), 1 - std::pow(0.05, 1.0 / 5), 1e-9);
    EXPECT_NEAR(upper_bound(0, 29), 1 - std::pow(0.05, 1.0 / 29), 1e-9);
    EXPECT_EQ(upper_bound(0, 0), 1);
    EXPECT_EQ(upper_bound(7, 7), 1);
}

// R: qbeta(0.95, events + 1, trials - events)
TEST(Bound, OfClopperAndPearson) {
    const struct {
        std::uint64_t events, trials;
        double bound;
    } cases[] = {{1, 10, 0.39416337}, {5, 10, 0.7775589}, {1, 100, 0.04655981}, {9, 10, 0.99488380}};
    for (const auto& [events, trials, bound] : cases)
        EXPECT_NEAR(upper_bound(events, trials), bound, 2e-7) << events << '/' << trials;
    // Poisson limits for rare events: 9.153519 / trials for 4 events.
    EXPECT_NEAR(upper_bound(4, 20'000'000) * 20'000'000, 9.153519, 1e-4);
}

RC_GTEST_PROP(Bound, ReachesTheConfidence, ()) {
    // The probability of at most `events` events at the bound is 5 %.
    const auto trials = *rc::gen::inRange<std::uint64_t>(1, 60);
    const auto events = *rc::gen::inRange<std::uint64_t>(1, trials + 1);
    RC_PRE(events < trials);
    const double p = upper_bound(events, trials);
    const auto n = static_cast<double>(trials);
    double sum = 0;
    for (double k = 0; k <= static_cast<double>(events); ++k)
        sum += std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) + k * std::log(p) +
                        (n - k) * std::log1p(-p));
    RC_ASSERT(std::abs(sum - 0.05) < 1e-8);
}

TEST(Bound, OneInHasTwoDigits) {
    EXPECT_EQ(one_in(1.0), 1u);
    EXPECT_EQ(one_in(0.5), 2u);
    EXPECT_EQ(one_in(1.0 / 99), 99u);
    EXPECT_EQ(one_in(1.0 / 999), 990u);
    EXPECT_EQ(one_in(1.0 / 12'345), 12'000u);
}

}  // namespace bound_test
}  // namespace takt::capture
