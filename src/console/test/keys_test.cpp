// Keys of a live display: from bytes, and what they change.
#include "takt/console/keys.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::console {
namespace keys_test {

using Name = Key::Name;

Key character(std::string text) {
    return {.name = Name::character, .character = std::move(text)};
}

std::vector<Key> keys_of(std::initializer_list<std::string_view> pieces) {
    KeyReader reader;
    std::vector<Key> keys;
    for (const auto piece : pieces) reader.feed(piece, [&](const Key& key) { keys.push_back(key); });
    return keys;
}

TEST(KeyReader, SequencesAndCharacters) {
    EXPECT_EQ(keys_of({"q\x1b[A\x1bOB\x1b[5~\x1b[6~\x1b[H\x1b[4~\r\x7f"}),
              (std::vector<Key>{character("q"),
                                {.name = Name::up},
                                {.name = Name::down},
                                {.name = Name::page_up},
                                {.name = Name::page_down},
                                {.name = Name::home},
                                {.name = Name::end},
                                {.name = Name::enter},
                                {.name = Name::erase}}));
    EXPECT_EQ(keys_of({"ж"}), std::vector<Key>{character("ж")});
}

TEST(KeyReader, WhatIsCutIsPutTogether) {
    EXPECT_EQ(keys_of({"\x1b[", "5", "~"}), std::vector<Key>{{.name = Name::page_up}});
    EXPECT_EQ(keys_of({"\xd0", "\xb6"}), std::vector<Key>{character("ж")});
}

TEST(KeyReader, ALoneEscIsAKeyAndUnknownBytesAreNone) {
    EXPECT_EQ(keys_of({"\x1b"}), std::vector<Key>{{.name = Name::escape}});
    EXPECT_EQ(keys_of({"\x1b\x1b[A"}), (std::vector<Key>{{.name = Name::escape}, {.name = Name::up}}));
    EXPECT_EQ(keys_of({"\x1b[99;5u", "\xff\xfe", "a"}), std::vector<Key>{character("a")});
    EXPECT_EQ(keys_of({"\x1b[" + std::string(100, '1'), "a"}).back(), character("a"))
        << "no end of the sequence";
}

class ApplyKey : public testing::Test {
protected:
    bool press(std::string_view bytes) {
        bool on = true;
        reader.feed(bytes, [&](const Key& key) { on = apply_key(selection, key, devices) && on; });
        return on;
    }

    std::vector<std::string> devices{"Boiler", "Pump"};
    report::LiveSelection selection{.page = 10};
    KeyReader reader;
};

TEST_F(ApplyKey, MovesTheRows) {
    EXPECT_TRUE(press("jj\x1b[B"));
    EXPECT_EQ(selection.first, 3U);
    press(" ");
    EXPECT_EQ(selection.first, 13U);
    press("\x1b[5~k");
    EXPECT_EQ(selection.first, 2U);
    press("kkkkk");
    EXPECT_EQ(selection.first, 0U);
    press("G");
    EXPECT_GT(selection.first, 1'000'000U);
    press("g");
    EXPECT_EQ(selection.first, 0U);
}

TEST_F(ApplyKey, TypesAFilter) {
    press("j/Teqж\x7f\x7fm");
    EXPECT_TRUE(selection.typing);
    EXPECT_EQ(selection.filter, "Tem");
    EXPECT_EQ(selection.first, 0U);
    EXPECT_TRUE(press("q")) << "a letter of the filter";
    press("\x7f\n");
    EXPECT_FALSE(selection.typing);
    EXPECT_EQ(selection.filter, "Tem");
    press("\x1b");
    EXPECT_EQ(selection.filter, "");
    press("/" + std::string(1000, 'x'));
    EXPECT_EQ(selection.filter.size(), 64U);
}

TEST_F(ApplyKey, GoesThroughTheDevices) {
    for (const auto* expected : {"Boiler", "Pump", "", "Boiler"}) {
        press("d");
        EXPECT_EQ(selection.device, expected);
    }
    devices.clear();
    press("d");
    EXPECT_EQ(selection.device, "");
}

TEST_F(ApplyKey, ShowsWhatIsNotGoodAndEnds) {
    press("!");
    EXPECT_TRUE(selection.not_good);
    press("!x");
    EXPECT_FALSE(selection.not_good);
    EXPECT_FALSE(press("q"));
}

}  // namespace keys_test
}  // namespace takt::console
