#include "takt/capture/time_line.hpp"

#include <gtest/gtest.h>

namespace takt::capture {
namespace time_line_test {

using namespace std::chrono_literals;

TEST(TimeLine, KeepsCountAndExtremesWhileItGrows) {
    TimeLine line;
    constexpr std::int64_t kStart = 1'700'000'000'000'000'000;
    std::int64_t time = kStart;
    for (int i = 0; i < 100'000; ++i) {
        line.record(time, Duration(1000 + i % 7));
        time += 1'000'000 + i * 100;
    }
    line.record(time, 5ms);
    ASSERT_LE(line.size(), TimeLine::kMost);
    EXPECT_GT(line.size(), TimeLine::kMost / 2);
    EXPECT_EQ(line.begin_ns(), kStart);
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        count += line[i].count;
        EXPECT_TRUE(line[i].count == 0 || line[i].min >= 1us);
    }
    EXPECT_EQ(count, 100'001u);
    EXPECT_EQ(line[line.size() - 1].max, 5ms);
    EXPECT_EQ((time - kStart) / line.width_ns(), static_cast<std::int64_t>(line.size()) - 1);
}

TEST(TimeLine, TimesBeforeTheFirstCountAsIt) {
    TimeLine line;
    line.record(100, 1us);
    line.record(50, 3us);
    EXPECT_EQ(line.size(), 1u);
    EXPECT_EQ(line[0].count, 2u);
    line.record(INT64_MAX, 1us);
    EXPECT_LE(line.size(), TimeLine::kMost);
}

}  // namespace time_line_test
}  // namespace takt::capture
