#include "takt/app/text_table.hpp"

#include <gtest/gtest.h>

namespace takt::app {
namespace {

TEST(TextTable, AlignsCharactersNotBytes) {
    TextTable table({TextTable::Align::left, TextTable::Align::right, TextTable::Align::left});
    table.add({"Насос", "7", "°C"});
    table.add({"Pump", "1500"});
    EXPECT_EQ(table.render(" "), " Насос     7  °C\n Pump   1500\n");
}

TEST(Fitted, CutsWholeCharacters) {
    EXPECT_EQ(fitted("Насос", 5), "Насос");
    EXPECT_EQ(fitted("Насос", 4), "Нас…");
    EXPECT_EQ(fitted("Насос", 1), "…");
    EXPECT_EQ(fitted("Насос", 0), "");
}

}  // namespace
}  // namespace takt::app
