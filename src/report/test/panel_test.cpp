// Lines in place, as a terminal that knows the four sequences shows them.
#include "takt/report/drawing/panel.hpp"

#include <gtest/gtest.h>

namespace takt::report {
namespace panel_test {

TEST(Panel, GoesBackUpOverWhatItDrew) {
    Panel panel;
    EXPECT_EQ(panel.draw({24, 80}, {"a", "b"}), "a\x1b[K\nb\x1b[K\n\x1b[J");
    EXPECT_EQ(panel.draw({24, 80}, {"c"}), "\x1b[2A\rc\x1b[K\n\x1b[J");
    EXPECT_EQ(panel.above({24, 80}, "news\n"), "\x1b[1A\r\x1b[Jnews\n");
    EXPECT_EQ(panel.above({24, 80}, "more\n"), "\x1b[Jmore\n");
    EXPECT_EQ(panel.draw({24, 80}, {"d"}), "d\x1b[K\n\x1b[J");
}

TEST(Panel, CutsEveryLineSoThatNoneWraps) {
    Panel panel;
    EXPECT_EQ(panel.draw({6, 6}, {"123456789", "12345"}), "1234…\x1b[K\n12345\x1b[K\n\x1b[J");
}

TEST(Panel, BeginsAnewWhereTheSizeChanged) {
    Panel panel;
    (void)panel.draw({24, 80}, {"a", "b"});
    EXPECT_EQ(panel.draw({12, 40}, {"a"}), "\x1b[H\x1b[2Ja\x1b[K\n\x1b[J");
    EXPECT_EQ(panel.draw({12, 40}, {"a"}), "\x1b[1A\ra\x1b[K\n\x1b[J");
}

TEST(Panel, NothingDrawnAndNothingToDraw) {
    Panel panel;
    EXPECT_EQ(panel.draw({24, 80}, {}), "\x1b[J");
    EXPECT_EQ(panel.draw({24, 80}, {}), "\x1b[J") << "there is nothing to go back over";
    EXPECT_EQ(panel.above({24, 80}, ""), "\x1b[J");
}

TEST(Panel, CutsByCharactersNotByBytes) {
    Panel panel;
    EXPECT_EQ(panel.draw({4, 6}, {"Насос 12"}), "Насо…\x1b[K\n\x1b[J");
}

}  // namespace panel_test
}  // namespace takt::report
