#include "takt/text/duration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace takt::text {
namespace duration_test {

// Both tables are also read by ui/test/words.test.ts.
constexpr const char* kDurations =
#include "durations.inc"
    ;
constexpr const char* kBounds =
#include "bounds.inc"
    ;

/// Nanoseconds and their text in each language.
struct Row {
    Duration duration;
    std::array<std::string, kLanguages.size()> texts;
};

std::vector<Row> rows_of(const char* table) {
    std::istringstream lines(table);
    std::string line;
    std::getline(lines, line);
    std::vector<Row> rows;
    while (std::getline(lines, line)) {
        auto end = line.find(" | ");
        Row row{.duration = Duration(std::stoll(line.substr(0, end))), .texts = {}};
        for (auto& text : row.texts) {
            const auto begin = end + 3;
            end = std::min(line.find(" | ", begin), line.size());
            text = line.substr(begin, end - begin);
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

TEST(Duration, HasItsDigitsAndUnitsInEachLanguage) {
    const auto rows = rows_of(kDurations);
    EXPECT_GT(rows.size(), 20U);
    for (const auto& [duration, texts] : rows)
        for (std::size_t i = 0; i < kLanguages.size(); ++i)
            EXPECT_EQ(duration_text(kLanguages[i], duration), texts[i]);
}

TEST(Duration, ABoundIsNotShownSmaller) {
    const auto rows = rows_of(kBounds);
    EXPECT_GT(rows.size(), 15U);
    for (const auto& [bound, texts] : rows) {
        const auto shown = rounded_up(bound);
        for (std::size_t i = 0; i < kLanguages.size(); ++i)
            EXPECT_EQ(duration_text(kLanguages[i], shown), texts[i]);
        EXPECT_GE(shown, bound);
        EXPECT_EQ(rounded_up(shown), shown) << bound.count();
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
