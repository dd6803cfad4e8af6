#include "takt/report/drawing/svg.hpp"

#include <gtest/gtest.h>

namespace takt::report {
namespace svg_test {

TEST(XmlText, EscapesMarkup) {
    EXPECT_EQ(xml_text("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
    EXPECT_EQ(xml_text("Котёл ²\n温度 🔥"), "Котёл ²\n温度 🔥");
}

TEST(XmlText, ReplacesWhatXmlDoesNotAllow) {
    const std::string bad = "\xEF\xBF\xBD";
    for (const std::string text : {"\x01", "\x1B", "\x80", "\xC0\x80", "\xE2\x82", "\xED\xA0\x80",
                                   "\xEF\xBF\xBE", "\xF5\x80\x80\x80"}) {
        const std::string escaped = xml_text(text);
        ASSERT_EQ(escaped.substr(0, 3), bad) << testing::PrintToString(text);
        for (std::size_t i = 0; i < escaped.size(); i += 3) EXPECT_EQ(escaped.substr(i, 3), bad);
    }
    EXPECT_EQ(xml_text("\x7F"), "\x7F");
    EXPECT_EQ(xml_text("a\x02z"), "a" + bad + "z");
}

TEST(TextWithin, CutsToWidth) {
    EXPECT_EQ(text_within("short", 10, 1000), "short");
    const std::string cut = text_within("a rather long text", 10, 60);
    EXPECT_LE(text_width(cut, 10), 60);
    EXPECT_TRUE(cut.ends_with("…"));
    EXPECT_EQ(text_within("anything", 10, -5), "");
}

TEST(Svg, IsADocument) {
    Svg svg;
    svg.begin_group("bar");
    svg.title("<&>");
    svg.rect({1, 2.5, 3.333, 4}, "request", " data-ns=\"7\"");
    svg.end_group();
    const std::string text = svg.document({100, 50, "uk", "a & b", ".page{fill:#fff}\n"});
    EXPECT_NE(text.find(R"(<rect class="request" x="1" y="2.5" width="3.33" height="4" data-ns="7"/>)"),
              std::string::npos);
    EXPECT_NE(text.find("<title>a &amp; b</title>"), std::string::npos);
    EXPECT_NE(text.find(R"(viewBox="0 0 100 50")"), std::string::npos);
    EXPECT_TRUE(text.ends_with("</g>\n</svg>\n"));
}

TEST(TextWidth, CountsCharacters) {
    EXPECT_EQ(text_width("", 13), 0);
    EXPECT_DOUBLE_EQ(text_width("Насос", 10), text_width("Pumps", 10));
    EXPECT_DOUBLE_EQ(text_width("a", 20), 2 * text_width("a", 10));
}

TEST(Svg, NumbersAreShort) {
    const struct {
        double value;
        const char* text;
    } cases[] = {{0, "0"}, {-0.001, "0"}, {12.5, "12.5"}, {100, "100"}, {1.0 / 3, "0.33"}, {-7.25, "-7.25"}};
    for (const auto& [value, text] : cases) {
        Svg svg;
        svg.line(value, 0, 0, 0, "grid");
        const auto document = svg.document({});
        EXPECT_NE(document.find("x1=\"" + std::string(text) + '"'), std::string::npos) << value;
    }
}

TEST(Svg, TextIsEscapedAndAnEmptyPictureIsADocument) {
    Svg svg;
    svg.text(1, 2, "row", "<Котёл & \x01>");
    EXPECT_NE(svg.document({}).find("&lt;Котёл &amp; \xEF\xBF\xBD&gt;</text>"), std::string::npos);
    const auto empty = Svg().document({10, 20, "en", "", ""});
    EXPECT_TRUE(empty.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg "));
    EXPECT_TRUE(empty.ends_with("</svg>\n"));
}

}  // namespace svg_test
}  // namespace takt::report
