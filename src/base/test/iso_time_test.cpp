#include "takt/base/iso_time.hpp"

#include <gtest/gtest.h>

namespace takt {
namespace iso_time_test {

TEST(IsoTime, IsWrittenInUtc) {
    const struct {
        std::int64_t ns;
        std::string_view text;
    } cases[] = {{0, "1970-01-01T00:00:00.000Z"},
                 {1'764'000'000'123'456'789, "2025-11-24T16:00:00.123Z"},
                 {-1, "1969-12-31T23:59:59.999Z"},
                 {951'827'696'999'999'999, "2000-02-29T12:34:56.999Z"}};
    for (const auto& [ns, text] : cases) {
        EXPECT_EQ(utc_time_text(ns), text);
        EXPECT_EQ(utc_time_text(ns, Fraction::none), std::string(text.substr(0, 19)) + 'Z');
        const auto back = read_time(text);
        ASSERT_TRUE(back) << text;
        EXPECT_EQ(utc_time_text(back->utc_ns()), text);
    }
}

TEST(IsoTime, IsWrittenWithTheOffsetOfAZone) {
    const struct {
        int minutes;
        const char* text;
    } cases[] = {{0, "2025-11-24T16:00:00.123+00:00"},
                 {120, "2025-11-24T18:00:00.123+02:00"},
                 {-210, "2025-11-24T12:30:00.123-03:30"}};
    for (const auto& [minutes, text] : cases)
        EXPECT_EQ(offset_time_text(1'764'000'000'123'456'789, std::chrono::minutes(minutes)), text);
    EXPECT_EQ(offset_time_text(-1, std::chrono::hours(1)), "1970-01-01T00:59:59.999+01:00");
}

TEST(IsoTime, CompleteTimesAreRead) {
    EXPECT_EQ(read_utc_time("1970-01-01T00:00:00Z"), 0);
    EXPECT_EQ(read_utc_time("1970-01-01t00:00:00.000000001+00:00"), 1);
    EXPECT_EQ(read_utc_time("1970-01-01T01:30:00+01:30"), 0);
    EXPECT_EQ(read_utc_time("1970-01-01T00:00:00-00:01"), 60 * kNanosecondsPerSecond);
    for (const auto* text :
         {"", "1970-01-01", "1970-01-01T00:00:00", "1970-02-30T00:00:00Z", "1970-01-01T24:00:00Z",
          "1970-01-01T00:60:00Z", "1970-01-01 00:00:00Z", "1970-01-01T00:00:00.Z", "1970-01-01T00:00:00Z ",
          "9999-01-01T00:00:00Z", "1970-01-01T00:00:00+1:00", "1970-01-01T00:00:00.1234567890Z",
          "1970-01-01T00:00Z", "1969-12-31T23:59:59Z"})
        EXPECT_FALSE(read_utc_time(text)) << text;
}

TEST(IsoTime, PartsMayBeMissing) {
    const auto day = read_time("2026-11-24");
    ASSERT_TRUE(day);
    EXPECT_FALSE(day->offset);
    EXPECT_FALSE(day->is_complete);
    const auto time = read_time("2026-11-24 10:00:30.25");
    ASSERT_TRUE(time);
    EXPECT_EQ(utc_time_text(time->utc_ns()), "2026-11-24T10:00:30.250Z");
    for (const auto* text : {"2026-11-24T", "2026-11-24T10", "2026-11-24T10:", "2026-11-24T10:00:",
                             "2026-11-24T10:00+2", "2026-11-24T10:00Zx", "26-11-24", "1699-01-01"})
        EXPECT_FALSE(read_time(text)) << text;
}

}  // namespace iso_time_test
}  // namespace takt
