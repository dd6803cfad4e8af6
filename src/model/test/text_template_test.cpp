#include "takt/model/text_template.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace takt::model {
namespace text_template_test {

/// "N name|L literal|…" or "@ position".
std::string findings_text(std::string_view text) {
    const auto parsed = parse_template(text);
    if (!parsed) return "@" + std::to_string(parsed.error().position);
    std::string all;
    for (const auto& piece : parsed->pieces) {
        all += all.empty() ? "" : "|";
        all += "LNHTS"[static_cast<int>(piece.kind)] + piece.text;
    }
    return all;
}

TEST(TextTemplate, Rows) {
    struct Row {
        std::string_view text;
        std::string expected;
    };
    const Row rows[] = {
        {"", ""},
        {"{w} kg", "Nw|L kg"},
        {"ST,{*},{w}{*", "@11"},
        {"{*}temp={value}\\r\\n", "S|Ltemp=|Nvalue|L\r\n"},
        {"{a:hex} {b:text}", "Ha|L |Tb"},
        {"\\x02\\{\\}\\\\\\t", "L\x02{}\\\t"},
        {"{a}{b}", "@4"},
        {"{*}{a}", "@4"},
        {"{a} {a}", "@5"},
        {"{1a}", "@1"},
        {"{a:bcd}", "@1"},
        {"{*:hex}", "@1"},
        {"}", "@1"},
        {"a\\", "@2"},
        {"\\q", "@1"},
        {"\\x1", "@1"},
        {"\\xG1", "@1"},
    };
    for (const auto& [text, expected] : rows) EXPECT_EQ(findings_text(text), expected) << text;
}

TEST(TextTemplate, BytesHaveNoPlaces) {
    EXPECT_EQ(parse_bytes("*00?\\r"), "*00?\r");
    EXPECT_EQ(parse_bytes("{x}\\0"), std::string("{x}\0", 4));
    EXPECT_EQ(parse_bytes("\\x").error().position, 1u);
    EXPECT_FALSE(parse_bytes(std::string(kMostTemplateBytes + 1, 'a')));
}

TEST(TextTemplate, Names) {
    const auto parsed = parse_template("{a} {*} {b:text}");
    EXPECT_EQ(parsed->names(), (std::vector<std::string_view>{"a", "b"}));
    EXPECT_TRUE(parsed->has("b"));
    EXPECT_FALSE(parsed->has(" "));
}

RC_GTEST_PROP(TextTemplate, AnyTextIsReadOrRefusedAtAPlaceInIt, (const std::string& text)) {
    const auto parsed = parse_template(text);
    if (!parsed) RC_ASSERT(parsed.error().position >= 1 && parsed.error().position <= text.size() + 1);
}

}  // namespace text_template_test
}  // namespace takt::model
