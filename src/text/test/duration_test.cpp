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

TEST(Duration, ExactTimesHaveTheUnitOfTheLanguage) {
    EXPECT_EQ(with_local_unit(Language::russian, "117.721 ms"), "117.721 мс");
    EXPECT_EQ(with_local_unit(Language::english, "117.721 ms"), "117.721 ms");
    for (const auto* text : {"", "5", "ms", " ms", "5ms", "5 mm", "5 ms or more", "Pump 5 ms", "∞"})
        EXPECT_EQ(with_local_unit(Language::ukrainian, text), text);
}

}  // namespace duration_test
}  // namespace takt::text
