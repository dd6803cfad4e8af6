#include <gtest/gtest.h>

#include "outline.hpp"

namespace takt::file {
namespace yaml_test {

using namespace std::string_view_literals;
using Findings = std::vector<std::string>;

TEST(Yaml, KeepsTextsAsWrittenWithTheirPlaces) {
    struct Case {
        std::string_view text;
        std::string_view outline;
    };
    constexpr Case kCases[] = {
        {"takt: 1\nx: 010\n", "{takt@1:1: 1@1:7, x@2:1: 010@2:4}@1:1"},
        {"a: '1'\nb: \"0x10\"\n", "{a@1:1: \"1\"@1:4, b@2:1: \"0x10\"@2:4}@1:1"},
        {"a: |\n  one\n  two\n", "{a@1:1: \"one\ntwo\n\"@1:4}@1:1"},
        {"a: {b: yes, c: [1, x y]}\n", "{a@1:1: {b@1:5: yes@1:8, c@1:13: [1@1:17, x y@1:20]@1:16}@1:4}@1:1"},
        {"- a: 1\n  b: 2\n-   c\n", "[{a@1:3: 1@1:6, b@2:3: 2@2:6}@1:3, c@3:5]@1:1"},
        // columns count characters, lines end with LF or CR LF, a byte order mark does not count
        {"кот: ёж # №\nё: [ё, x]\n", "{кот@1:1: ёж@1:6, ё@2:1: [ё@2:5, x@2:8]@2:4}@1:1"},
        {"\xEF\xBB\xBF"
         "a: 1\r\nb: 2\r\n",
         "{a@1:1: 1@1:4, b@2:1: 2@2:4}@1:1"},
        // nothing stands where its key or its dash does
        {"a:\n\nb: ~\nc: null\n", "{a@1:1: null@1:1, b@3:1: null@3:4, c@4:1: null@4:4}@1:1"},
        {"-\n\n- # none\n- x\n", "[null@1:1, null@3:8, x@4:3]@1:1"},
        {"[]", "[]@1:1"},
        {"%YAML 1.2\n---\na: 1\n...\n", "{a@3:1: 1@3:4}@3:1"},
        {"? a\n: 1\n\"<<\": 2\n", "{a@1:3: 1@2:3, \"<<\"@3:1: 2@3:7}@1:1"},
    };
    for (const auto& [text, expected] : kCases) {
        const auto loaded = load_text("p.yaml", std::string(text));
        EXPECT_EQ(outline(loaded.document.root), expected) << text;
        EXPECT_EQ(locations_and_codes(loaded), Findings{}) << text;
        EXPECT_TRUE(loaded.readable);
        EXPECT_EQ(loaded.document.files, std::vector<std::string>{"p.yaml"});
    }
}

TEST(Yaml, RefusesWhatMakesADocumentAmbiguousAndGoesOn) {
    struct Case {
        std::string_view text;
        std::string_view outline;  // of what is left
        Findings findings;
    };
    const Case cases[] = {
        {"a: 1\nb: {c: 1, c: 2, 'c': 3}\na: 2\n",
         "{a@1:1: 1@1:4, b@2:1: {c@2:5: 1@2:8}@2:4}@1:1",
         {"2:11 duplicate_key", "2:17 duplicate_key", "3:1 duplicate_key"}},
        {"a: &x 1\nb: *x\nc: 2\n", "{a@1:1: 1@1:4, c@3:1: 2@3:4}@1:1", {"1:4 anchor", "2:4 alias"}},
        {"a: &x [*x, 1]\n", "{a@1:1: [1@1:12]@1:4}@1:1", {"1:4 anchor", "1:8 alias"}},
        {"&k a: 1\n*k : 2\nc: 3\n", "{a@1:1: 1@1:7, c@3:1: 3@3:4}@1:1", {"1:1 anchor", "2:1 alias"}},
        {"a: !!int 5\nb: ! 6\nc: !x {d: 1}\ne: !!str\n",
         "{a@1:1: 5@1:4, b@2:1: \"6\"@2:4, c@3:1: {d@3:8: 1@3:11}@3:4, e@4:1: @4:4}@1:1",
         {"1:4 tag", "2:4 tag", "3:4 tag", "4:4 tag"}},
        {"a: 1\n<<: {b: 2}\n", "{a@1:1: 1@1:4}@1:1", {"2:1 merge_key"}},
        {"? {x: 1}\n: 2\n? [y]\n: 3\n~: 4\na: 5\n", "{a@6:1: 5@6:4}@1:1", {"1:3 key", "3:3 key", "5:1 key"}},
        {"a: \"x\\0y\"\nb: \"\\e[1m\"\nc: \"\\t\\n\"\n",
         "{a@1:1: \"x\0y\"@1:4, b@2:1: \"\x1B[1m\"@2:4, c@3:1: \"\t\n\"@3:4}@1:1"sv,
         {"1:4 control_character", "2:4 control_character"}},
    };
    for (const auto& [text, expected, findings] : cases) {
        const auto loaded = load_text("p.yaml", std::string(text));
        EXPECT_EQ(outline(loaded.document.root), expected) << text;
        EXPECT_EQ(locations_and_codes(loaded), findings) << text;
        EXPECT_TRUE(loaded.readable) << text;
    }
}

TEST(Yaml, SaysWhereAndWhyItCannotBeRead) {
    struct Case {
        std::string_view text;
        std::string finding;
    };
    const Case cases[] = {
        {"", "0:0 empty"},
        {"\n \r\n", "0:0 empty"},
        {"# nothing\n", "0:0 no_content"},
        {"---\n~\n", "0:0 no_content"},
        {"a: 1\n---\nb: 2\n", "2:1 second_document"},
        {"a: 1\n...\n--- 2\n", "3:1 second_document"},
        {"  a: 1\nb: 2\n", "2:1 left_over"},
        {"- a\nb: 1\n", "2:1 left_over"},
        {"a: 1\n...\nb\n", "3:1 left_over"},
        {"a: 1\nb: \"cut", "2:4 unclosed_quote"},
        {"a: 1\nb: 'it''s cut\nc: 2\n", "2:4 unclosed_quote"},
        {"a: [\"cut \\\" \n", "1:5 unclosed_quote"},
        {"a: \"open\n---\nb: 1\n", "2:1 unclosed_quote"},
        {"a: \"open\nb: 1\nc: \"x\"\n", "3:5 quote_ended"},
        {"a: [1, 2\n", "1:9 unclosed_bracket"},
        {"a: {b: 1 c: 2}\n", "1:11 unclosed_bracket"},
        {"a:\n  - {b: 1,\n     c: [2,\n", "3:12 unclosed_bracket"},
        {"a: [1]]\n", "1:7 bracket"},
        {"a:\n\t- b\n", "2:1 tab"},
        {"a:\n  b: 1\n\tc: 2\n", "3:1 tab"},
        {"\ta: 1\n", "1:1 tab"},
        {"a:\n  - b: 1\n c: 2\n", "3:2 indentation"},
        {"a: \"x\" y\n", "1:8 indentation"},
        {"a: 1\n b: 2\n", "2:3 colon"},
        {"a: b: c\n", "1:5 colon"},
        {"a: b\n  - c\nd: - e\n", "3:4 list_entry"},
        {"a: @b\n", "1:4 reserved_character"},
        {"a: %b\n", "1:4 reserved_character"},
        {"a: \"\\q\"\n", "1:7 escape"},
        {"a: \"\\ud800\"\n", "1:11 escape"},
        {"a: *none\n", "1:4 alias"},
        {"a: |x\n", "1:5 syntax"},
        {"%YAML 9\n---\na: 1\n", "1:1 syntax"},
        {"a: \xFF\n", "1:4 not_utf8"},
        {"a: x\0y\n"sv, "1:5 control_character"},
        {"\xFF\xFE"
         "a\0:\0"sv,
         "1:1 not_utf8"},
        {"a\0:\0 \0"sv, "1:2 control_character"},
        {"a: 1\rb: 2\r", "1:5 control_character"},
        {"ё: \xC0\xAF\n", "1:4 not_utf8"},
        {"a: \xED\xA0\x80\n", "1:4 not_utf8"},
        {"a: \xF4\x90\x80\x80\n", "1:4 not_utf8"},
        {"a: \xE2\x82", "1:4 not_utf8"},
        {"a: \xC2\x9B"
         "1m\n",
         "1:4 control_character"},
        {"\xEF\xBB\xBF\xEF\xBB\xBF"
         "a: 1\n",
         "1:1 control_character"},
    };
    for (const auto& [text, finding] : cases) {
        const auto loaded = load_text("p.yaml", std::string(text));
        EXPECT_EQ(locations_and_codes(loaded), Findings{finding}) << text;
        EXPECT_FALSE(loaded.readable) << text;
        EXPECT_EQ(outline(loaded.document.root), "null@0:0") << text;
    }
}

TEST(Yaml, FindingsNameTheFieldAndWhereItWasFirst) {
    const auto loaded =
        load_text("p.yaml", "lines:\n  - name: a\n    devices:\n      - address: 1\n        address: 2\n");
    ASSERT_EQ(loaded.findings.size(), 1U);
    const auto& finding = loaded.findings[0];
    EXPECT_EQ(finding.path, "lines[0].devices[0].address");
    EXPECT_EQ(finding.value, "address");
    EXPECT_EQ(finding.arguments, (decltype(finding.arguments){{"first", "4"}}));
    EXPECT_EQ(finding.severity, model::Severity::error);
}

}  // namespace yaml_test
}  // namespace takt::file
