#include "takt/report/drawing/text_table.hpp"

#include <gtest/gtest.h>

namespace takt::report {
namespace text_table_test {

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
    EXPECT_EQ(table.lines(3)[0], "Boiler  Suppl…  17.25") << "not below what is legible";
    EXPECT_EQ(table.render("  ", 27), "  Boiler  Supply te…  17.25\n  Pump    Speed        1500\n");
}

TEST(TextTable, NoRowsAndNoCells) {
    EXPECT_EQ(TextTable({}).render(), "");
    TextTable table({TextTable::Align::left, TextTable::Align::right});
    EXPECT_EQ(table.render(), "");
    table.add({});
    table.add({"", ""});
    EXPECT_EQ(table.render("  "), "  \n  \n");
}

TEST(TextTable, EveryLineHasTheSameColumnsInEveryScript) {
    TextTable table({TextTable::Align::left, TextTable::Align::right, TextTable::Align::left});
    for (const char* name : {"Temperature", "Температура", "Подача води", "°C", ""})
        table.add({name, "12.5", "|"});
    const auto lines = table.lines();
    for (const auto& line : lines) {
        EXPECT_TRUE(line.ends_with("12.5  |")) << line;
        EXPECT_EQ(display_width(line), display_width(lines[0])) << line;
    }
}

TEST(TextTable, AHugeTableKeepsItsWidth) {
    TextTable table({TextTable::Align::left, TextTable::Align::right});
    for (int i = 0; i < 20000; ++i) table.add({"row", std::to_string(i)});
    table.add({std::string(100000, 'x'), "1"});
    const auto lines = table.lines(80);
    ASSERT_EQ(lines.size(), 20001U);
    EXPECT_EQ(display_width(lines.back()), 80U);
    EXPECT_TRUE(lines[19999].ends_with("19999"));
}

TEST(DisplayWidth, CountsCharacters) {
    EXPECT_EQ(display_width(""), 0U);
    EXPECT_EQ(display_width("Насос"), 5U);
    EXPECT_EQ(display_width("a°…█"), 4U);
}

TEST(Fitted, CutsWholeCharacters) {
    EXPECT_EQ(fitted("Насос", 5), "Насос");
    EXPECT_EQ(fitted("Насос", 4), "Нас…");
    EXPECT_EQ(fitted("Насос", 1), "…");
    EXPECT_EQ(fitted("Насос", 0), "");
}

}  // namespace text_table_test
}  // namespace takt::report
