// Which repeated messages are written, in time that the test moves.
#include "sessions/repeat_filter.hpp"

#include <gtest/gtest.h>

#include <string>

namespace takt::host::test {
namespace repeat_filter_test {

using namespace std::chrono_literals;

struct Bench {
    RepeatFilter<int> filter{60s, 3};
    Instant now{};
    std::string reports;

    void sweep(bool end = false) {
        const auto report = [this](int key, std::uint64_t count, Duration in) {
            reports +=
                std::to_string(key) + " x" + std::to_string(count) + " in " + std::to_string(in / 1s) + "; ";
        };
        const auto omitted = [this](std::uint64_t count, Duration in) {
            reports += "others x" + std::to_string(count) + " in " + std::to_string(in / 1s) + "; ";
        };
        end ? filter.finish(now, report, omitted) : filter.sweep(now, report, omitted);
    }
};

TEST(RepeatFilter, TheFirstOfEachKeyIsWritten) {
    Bench bench;
    EXPECT_TRUE(bench.filter.admit(bench.now, 1));
    EXPECT_TRUE(bench.filter.admit(bench.now, 2));
    EXPECT_FALSE(bench.filter.admit(bench.now, 1));
}

TEST(RepeatFilter, RepeatedOnesAreCountedInEachWindow) {
    Bench bench;
    for (int i = 0; i < 600; ++i, bench.now += 250ms) {
        EXPECT_EQ(bench.filter.admit(bench.now, 1), i == 0) << i;
        bench.sweep();
    }
    EXPECT_EQ(bench.reports, "1 x240 in 60; 1 x240 in 60; ");
    bench.sweep(true);
    EXPECT_EQ(bench.reports, "1 x240 in 60; 1 x240 in 60; 1 x119 in 30; ");
}

TEST(RepeatFilter, TheWindowsGrow) {
    Bench bench{.filter{60s, 3, 200s}};
    for (int i = 0; i < 4 * 600; ++i, bench.now += 250ms) {
        EXPECT_EQ(bench.filter.admit(bench.now, 1), i == 0) << i;
        bench.sweep();
    }
    EXPECT_EQ(bench.reports, "1 x240 in 60; 1 x480 in 120; 1 x800 in 200; 1 x800 in 200; ");
}

TEST(RepeatFilter, AfterAQuietWindowAMessageIsNewAgain) {
    Bench bench;
    EXPECT_TRUE(bench.filter.admit(bench.now, 1));
    bench.now += 29s;
    bench.sweep();
    EXPECT_FALSE(bench.filter.admit(bench.now, 1));
    bench.now += 31s;
    bench.sweep();
    bench.now += 60s;
    bench.sweep();
    EXPECT_TRUE(bench.filter.admit(bench.now, 1));
    EXPECT_EQ(bench.reports, "1 x1 in 60; ");
}

TEST(RepeatFilter, AMessageThatComesHalfAWindowLaterIsNoRepetition) {
    Bench bench;
    for (int i = 0; i < 5; ++i) {
        EXPECT_TRUE(bench.filter.admit(bench.now, 1));
        bench.now += 30s;
        bench.sweep();
    }
    EXPECT_EQ(bench.reports, "");
}

TEST(RepeatFilter, RemembersABoundedNumberOfKeys) {
    Bench bench;
    for (int key = 0; key < 10; ++key) EXPECT_EQ(bench.filter.admit(bench.now, key), key < 3);
    bench.now += 60s;
    bench.sweep();
    EXPECT_EQ(bench.reports, "others x7 in 60; ");
    EXPECT_TRUE(bench.filter.admit(bench.now, 9)) << "the window is over";
}

}  // namespace repeat_filter_test
}  // namespace takt::host::test
