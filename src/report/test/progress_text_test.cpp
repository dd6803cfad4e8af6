#include "takt/report/drawing/progress_text.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace progress_text_test {

using namespace test;
using namespace std::chrono_literals;

TEST(ProgressText, Bars) {
    const struct {
        std::size_t done, total, width;
        const char* text;
    } cases[] = {{0, 10, 4, "[----]"}, {5, 10, 4, "[##--]"}, {12, 10, 4, "[####]"},
                 {0, 0, 4, "[----]"},  {9, 10, 4, "[###-]"}, {1, 2, 0, "[]"}};
    for (const auto& c : cases) EXPECT_EQ(progress_bar(c.done, c.total, c.width), c.text);
}

TEST(ProgressText, LinesInEveryLanguage) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto share = [&](const char* percent, const char* what) {
            return texts("app.progress", {{"percent", percent}, {"what", what}});
        };
        const auto rate = [&](const char* number) { return texts("app.progress.rate", {{"rate", number}}); };
        const auto left = texts("app.progress.left", {{"time", texts.duration(30s)}});
        EXPECT_EQ(progress_line(texts, {0, 10, 0}, 1s, "шаг"), share("0", "шаг") + rate("0.0"))
            << "no pace yet";
        EXPECT_EQ(progress_line(texts, {5, 20, 30}, 10s, "x"), share("25", "x") + rate("3.0") + left);
        EXPECT_EQ(progress_line(texts, {20, 20, 30}, 10s, "x"), share("100", "x") + rate("3.0"));
        EXPECT_EQ(progress_line(texts, {5, 20}, 10s, "x"), share("25", "x")) << "nothing is sent";
        EXPECT_EQ(progress_line(texts, {5, 0}, 10s, "x"), "x") << "the total is unknown";
        expect_complete(progress_line(texts, {1, 2, 3}, 4s, "x"));
    }
}

TEST(ProgressText, TheBarTakesWhatIsLeftOfTheColumns) {
    const Done half{.done = 5, .total = 10};
    const auto words = progress_line(english(), half, 10s, "x");
    const auto beside = display_width(words) + 4;
    const struct {
        std::size_t columns, width;
    } cases[] = {{200, 24}, {beside + 24, 24}, {beside + 23, 23}, {beside + 6, 6}};
    for (const auto& [columns, width] : cases) {
        const auto text = progress_with_bar(english(), half, 10s, "x", columns);
        EXPECT_EQ(text, progress_bar(5, 10, width) + ' ' + words);
        EXPECT_LT(display_width(text), columns);
    }
    for (const std::size_t columns : {beside + 5, std::size_t{10}, std::size_t{1}})
        EXPECT_LT(display_width(progress_with_bar(english(), half, 10s, "x", columns)), columns);
}

TEST(ProgressText, OddInputs) {
    expect_contains(progress_line(english(), {1, 0, 5}, 0s, "x"), "0 %");
    expect_contains(progress_line(english(), {30, 20, 5}, -3s, "x"), "100 %");
    expect_complete(progress_line(english(), {1, SIZE_MAX / 1000, 5}, 1ms, "x"));
}

}  // namespace progress_text_test
}  // namespace takt::report
