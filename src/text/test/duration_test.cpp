#include "takt/text/duration.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <sstream>
#include <string>

namespace takt::text {
namespace duration_test {

// Also read by ui/test/words.test.ts.
constexpr const char* kTable =
#include "durations.inc"
    ;

TEST(Duration, HasItsDigitsAndUnitsInEachLanguage) {
    std::istringstream rows(kTable);
    std::string row;
    std::getline(rows, row);
    int count = 0;
    for (; std::getline(rows, row); ++count) {
        std::array<std::string, 4> cells;
        std::size_t begin = 0;
        for (auto& cell : cells) {
            const auto end = std::min(row.find(" | ", begin), row.size());
            cell = row.substr(begin, end - begin);
            begin = std::min(end + 3, row.size());
        }
        for (std::size_t i = 0; i < kLanguages.size(); ++i)
            EXPECT_EQ(duration_text(kLanguages[i], Duration(std::stoll(cells[0]))), cells[i + 1]);
    }
    EXPECT_GT(count, 20);
}

TEST(Duration, ABoundIsNotShownSmaller) {
    const struct {
        std::int64_t ns;
        std::string_view text;
    } cases[] = {{60'525'000'000, "1 min 1 s"},
                 {12'310'000, "12.4 ms"},
                 {12'300'000, "12.3 ms"},
                 {9'991'000, "10.0 ms"},
                 {100'000'001, "101 ms"},
                 {9'999'000'001, "10 s"},
                 {12'340'000'000, "12.4 s"},
                 {59'950'000'000, "1 min"},
                 {3'600'000'000'001, "1 h 1 min"},
                 {1'001, "1.01 µs"},
                 {99'950, "0.10 ms"},
                 {0, "0 ms"}};
    for (const auto& [ns, text] : cases) {
        const auto shown = rounded_up(Duration(ns));
        EXPECT_EQ(duration_text(Language::english, shown), text);
        EXPECT_GE(shown, Duration(ns));
        EXPECT_EQ(rounded_up(shown), shown) << ns;
    }
}

TEST(Duration, ExactTimesHaveTheUnitOfTheLanguage) {
    EXPECT_EQ(with_local_unit(Language::russian, "117.721 ms"), "117.721 мс");
    EXPECT_EQ(with_local_unit(Language::english, "117.721 ms"), "117.721 ms");
    for (const auto* text : {"", "5", "ms", " ms", "5ms", "5 mm", "5 ms or more", "Pump 5 ms", "∞"})
        EXPECT_EQ(with_local_unit(Language::ukrainian, text), text);
}

}  // namespace duration_test
}  // namespace takt::text
