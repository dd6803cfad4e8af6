#include "takt/report/text_table.hpp"

#include <gtest/gtest.h>

namespace takt::report {
namespace {

TEST(TextTable, AlignsCharactersNotBytes) {
    TextTable table({TextTable::Align::left, TextTable::Align::right, TextTable::Align::left});
    table.add({"Насос", "7", "°C"});
    table.add({"Pump", "1500"});
    EXPECT_EQ(table.render(" "), " Насос     7  °C\n Pump   1500\n");
}

TEST(TextTable, WhereItIsTooWideWordsAreCutAndNumbersAreNot) {
    TextTable table({TextTable::Align::left, TextTable::Align::left, TextTable::Align::right});
    table.add({"Boiler", "Supply temperature", "17.25"});
    table.add({"Pump", "Speed", "1500"});
    EXPECT_EQ(table.lines(25),
              (std::vector<std::string>{"Boiler  Supply te…  17.25", "Pump    Speed        1500"}));
    EXPECT_EQ(table.lines(3)[0], "Boiler  Suppl…  17.25") << "not below what can be told";
}

TEST(Fitted, CutsWholeCharacters) {
    EXPECT_EQ(fitted("Насос", 5), "Насос");
    EXPECT_EQ(fitted("Насос", 4), "Нас…");
    EXPECT_EQ(fitted("Насос", 1), "…");
    EXPECT_EQ(fitted("Насос", 0), "");
}

}  // namespace
}  // namespace takt::report
