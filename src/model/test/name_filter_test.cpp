#include "takt/model/name_filter.hpp"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

namespace takt::model {
namespace name_filter_test {

TEST(NameFilter, PatternsFitAsInAShell) {
    const std::tuple<std::string_view, std::string_view, bool> cases[] = {
        {"Power", "Power", true},
        {"Power", "power", false},
        {"Power", "Power*", true},
        {"Power1", "Power*", true},
        {"", "*", true},
        {"", "?", false},
        {"", "", true},
        {"a", "", false},
        {"Power1", "*1", true},
        {"Power12", "*1", false},
        {"a.b.c", "a.*.c", true},
        {"a.c", "a.*.c", false},
        {"abcabd", "*abd", true},
        {"abcabc", "*abd", false},
        {"aXbXc", "a?b?c", true},
        {"ab", "a?b", false},
        {"Öl", "?l", true},
        {"Давление", "Давл*", true},
        {"Давление", "Давлени?", true},
        {"Давление", "Давлен?", false},
        {"xyz", "***z", true},
        {"xyz", "x**?", true},
        {"x", "x**?", false},
    };
    for (const auto& [name, pattern, expected] : cases)
        EXPECT_EQ(fits(name, pattern), expected) << name << ' ' << pattern;
}

TEST(NameFilter, EachPatternNotesItsUse) {
    NameFilter filter;
    for (const auto* pattern : {"Power*", "Flow", "P*", "Gone?", "Flow"}) filter.add(pattern);
    EXPECT_TRUE(filter.select("Power"));
    EXPECT_TRUE(filter.select("Flow"));
    EXPECT_FALSE(filter.select("flow"));
    EXPECT_FALSE(filter.select("Gone"));
    std::string used;
    for (std::size_t i = 0; i < filter.size(); ++i) used += filter.used(i) ? '1' : '0';
    EXPECT_EQ(used, "11100") << "of equal patterns the first one counts";
}

TEST(NameFilter, ManyStarsTakeNoTime) {
    const std::string name(2000, 'a');
    std::string pattern;
    for (int i = 0; i < 200; ++i) pattern += "*a";
    EXPECT_TRUE(fits(name, pattern));
    EXPECT_FALSE(fits(name, pattern + "b"));
}

}  // namespace name_filter_test
}  // namespace takt::model
