#include "takt/base/token_bucket.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace takt {
namespace token_bucket_test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

TEST(TokenBucket, AdmitsTheBurstThenOneEachInterval) {
    struct Step {
        Duration when;
        bool admitted;
    };
    constexpr Step kSteps[] = {
        {0ms, true},   {0ms, true},   {0ms, false},  // burst of two
        {99ms, false}, {100ms, true}, {150ms, false}, {200ms, true},
        {900ms, true}, {900ms, true}, {900ms, false},  // refilled, but never beyond the burst
    };
    auto bucket = TokenBucket::create(2, 100ms).value();
    for (const auto& [when, admitted] : kSteps) EXPECT_EQ(bucket.admit(at(when)), admitted) << when.count();
}

TEST(TokenBucket, RefusesImpossibleLimits) {
    EXPECT_EQ(TokenBucket::create(0, 1ms).error().code, Code::out_of_range);
    EXPECT_EQ(TokenBucket::create(1, 0ms).error().code, Code::out_of_range);
    EXPECT_EQ(TokenBucket::create(1'000'001, 1ms).error().code, Code::out_of_range);
    EXPECT_EQ(TokenBucket::create(1'000'000, 24h).error().code, Code::out_of_range);
}

RC_GTEST_PROP(TokenBucket, NeverAdmitsMoreThanItsBound, ()) {
    const auto burst = *rc::gen::inRange<std::uint32_t>(1, 5);
    const auto gaps = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 30));
    auto bucket = TokenBucket::create(burst, 10ms).value();
    std::vector<Instant> admitted;
    Instant now{};
    for (int gap_ms : gaps) {
        now += gap_ms * 1ms;
        if (bucket.admit(now)) admitted.push_back(now);
    }
    for (std::size_t first = 0; first < admitted.size(); ++first)
        for (std::size_t last = first; last < admitted.size(); ++last)
            RC_ASSERT(last - first + 1 <= burst + (admitted[last] - admitted[first]) / 10ms);
}

}  // namespace token_bucket_test
}  // namespace takt
