#include "journal/journal_losses.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

namespace takt::store {
namespace journal_losses_test {

using Pair = std::pair<std::uint64_t, std::uint64_t>;

Pair after(const KnownLosses& losses, std::uint64_t samples) {
    const auto sum = losses.after(samples);
    return {sum.samples, sum.gaps};
}

TEST(KnownLosses, CountsWhatIsBehindAPosition) {
    KnownLosses losses;
    losses.add(10, 5, GapCause::damaged);
    losses.add(30, 2, GapCause::buffer_full);
    losses.add(40, 0, GapCause::restart);
    EXPECT_EQ(after(losses, 0), Pair(7, 2));
    EXPECT_EQ(after(losses, 10), Pair(7, 2));
    EXPECT_EQ(after(losses, 12), Pair(5, 2));
    EXPECT_EQ(after(losses, 15), Pair(2, 1));
    EXPECT_EQ(after(losses, 32), Pair(0, 0));
}

TEST(KnownLosses, CountsNothingTwice) {
    KnownLosses losses;
    losses.add(10, 5, GapCause::damaged);
    losses.add(10, 5, GapCause::damaged);
    losses.add(12, 10, GapCause::damaged);
    losses.add(8, 3, GapCause::damaged);
    EXPECT_EQ(after(losses, 0), Pair(14, 1));
    losses.add(0, 100, GapCause::quota);
    EXPECT_EQ(after(losses, 0), Pair(100, 1));
}

TEST(KnownLosses, GapsThatTouchAreTwoButForTheQuota) {
    KnownLosses losses;
    losses.add(20, 10, GapCause::quota);
    losses.add(30, 10, GapCause::quota);
    losses.add(10, 10, GapCause::quota);
    EXPECT_EQ(after(losses, 0), Pair(30, 1));
    losses.add(40, 10, GapCause::damaged);
    losses.add(50, 10, GapCause::damaged);
    losses.add(60, 10, GapCause::quota);
    EXPECT_EQ(after(losses, 0), Pair(60, 4));
}

TEST(KnownLosses, ForgetsWhatIsPassed) {
    KnownLosses losses;
    for (std::uint64_t begin = 0; begin < 100; begin += 10) losses.add(begin, 4, GapCause::source_lost);
    losses.forget(33);
    EXPECT_EQ(after(losses, 0), Pair(28, 7)) << "a range that is passed in part stays whole";
    EXPECT_EQ(after(losses, 33), Pair(25, 7));
    losses.forget(1000);
    EXPECT_EQ(after(losses, 0), Pair(0, 0));
}

}  // namespace journal_losses_test
}  // namespace takt::store
