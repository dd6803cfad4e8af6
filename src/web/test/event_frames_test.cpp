#include "live/event_frames.hpp"

#include <gtest/gtest.h>

namespace takt::web {
namespace event_frames_test {

using enum text::Language;

TEST(EventFrames, GivesEachReaderItsFrames) {
    EventFrames frames(10, 1000);
    auto early = frames.end();
    frames.push("a", 2);
    auto late = frames.end();
    frames.push("b", 3);
    std::string text;
    EXPECT_TRUE(frames.read(early, english, text));
    EXPECT_EQ(text, "ab");
    EXPECT_EQ(early.items, 5u);
    text.clear();
    EXPECT_TRUE(frames.read(late, russian, text));
    EXPECT_EQ(text, "b");
    text.clear();
    EXPECT_TRUE(frames.read(late, russian, text));
    EXPECT_EQ(text, "");
}

TEST(EventFrames, GivesTextsOfALanguage) {
    EventFrames frames(10, 1000);
    auto cursor = frames.end();
    FrameTexts texts;
    texts[static_cast<std::size_t>(russian)] = std::make_shared<const std::string>("да");
    frames.push(texts);
    auto other = cursor;
    std::string text;
    EXPECT_TRUE(frames.read(cursor, russian, text));
    EXPECT_EQ(text, "да");
    EXPECT_TRUE(frames.read(other, english, text));
    EXPECT_EQ(text, "да");
}

TEST(EventFrames, DropsTheOldestAndReportsIt) {
    EventFrames by_count(2, 1000);
    auto cursor = by_count.end();
    for (const auto* text : {"a", "b", "c"}) by_count.push(text, 1);
    std::string text;
    EXPECT_FALSE(by_count.read(cursor, english, text));
    EXPECT_EQ(by_count.begin().items - cursor.items, 1u);
    cursor = by_count.begin();
    EXPECT_TRUE(by_count.read(cursor, english, text));
    EXPECT_EQ(text, "bc");

    EventFrames by_bytes(100, 10);
    for (int i = 0; i < 5; ++i) by_bytes.push("12345678");
    EXPECT_EQ(by_bytes.end().frame - by_bytes.begin().frame, 1u);
}

TEST(EventFrames, ReadsLargeRestsInParts) {
    EventFrames frames(100, 10 << 20);
    auto cursor = frames.end();
    for (int i = 0; i < 10; ++i) frames.push(std::string(30'000, 'x'));
    std::string text;
    EXPECT_TRUE(frames.read(cursor, english, text));
    EXPECT_EQ(text.size(), 90'000u);
}

}  // namespace event_frames_test
}  // namespace takt::web
