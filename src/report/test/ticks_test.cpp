#include "drawing/ticks.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

namespace takt::report {
namespace ticks_test {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(Ticks, OfValuesAreRound) {
    const struct {
        double least;
        double greatest;
        std::vector<double> ticks;
    } cases[] = {{48.74, 72.22, {50, 60, 70}},
                 {-0.06, 1.06, {0, 0.5, 1}},
                 {0.0011, 0.0049, {0.002, 0.003, 0.004}},
                 {-250, 750, {0, 500}},
                 {1e12, 1e12 + 4, {1e12, 1e12 + 1, 1e12 + 2, 1e12 + 3, 1e12 + 4}},
                 {5, 5, {}}};
    for (const auto& [least, greatest, ticks] : cases) {
        const auto found = value_ticks(least, greatest, 4);
        ASSERT_EQ(found.size(), ticks.size()) << least;
        for (std::size_t i = 0; i < ticks.size(); ++i) EXPECT_DOUBLE_EQ(found[i], ticks[i]) << least;
    }
}

std::string texts_of(std::int64_t from_s, std::int64_t to_s) {
    std::string texts;
    for (const auto& tick : time_ticks({from_s * kSecond, to_s * kSecond}, 6))
        texts += (texts.empty() ? "" : ", ") + tick.text;
    return texts;
}

TEST(Ticks, OfTimesAreFullLocalTimes) {
    ::setenv("TZ", "Europe/Kyiv", 1);
    ::tzset();
    constexpr std::int64_t kStart = 1'790'000'003;  // 2026-09-21 17:13:23 +03:00
    EXPECT_EQ(texts_of(kStart, kStart + 12),
              "2026-09-21 17:13:24, 17:13:26, 17:13:28, 17:13:30, 17:13:32, 17:13:34");
    EXPECT_EQ(texts_of(kStart, kStart + 3600), "2026-09-21 17:20, 17:30, 17:40, 17:50, 18:00, 18:10");
    EXPECT_EQ(texts_of(kStart, kStart + 48 * 3600), "2026-09-22 00:00, 12:00, 2026-09-23 00:00, 12:00");
    EXPECT_EQ(texts_of(kStart, kStart + 4 * 86400),
              "2026-09-22 00:00, 2026-09-23 00:00, 2026-09-24 00:00, 2026-09-25 00:00");
    ::unsetenv("TZ");
    ::tzset();
}

}  // namespace ticks_test
}  // namespace takt::report
