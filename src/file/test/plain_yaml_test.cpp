// The fast reader against yaml-cpp: what it accepts, it reads alike.
#include "plain_yaml.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "outline.hpp"
#include "yaml.hpp"

namespace takt::file {
namespace {

constexpr std::size_t kNodes = 300;

struct Read {
    bool complete = false;
    std::string outline;
    std::vector<std::string> findings;
    std::size_t nodes_left = kNodes;
    friend bool operator==(const Read&, const Read&) = default;
};

std::vector<std::string> findings_of(Reporter& reporter) {
    std::vector<std::string> lines;
    for (const auto& finding : reporter.take())
        lines.push_back(at(finding.location) + " " + finding.code + " " + finding.path + " " + finding.value);
    return lines;
}

Read with_library(const std::string& text) {
    Read read;
    Reporter reporter;
    const auto root = read_any_yaml(Source(0, text), read.nodes_left, reporter);
    read.complete = root.has_value();
    if (root) read.outline = outline(*root);
    read.findings = findings_of(reporter);
    return read;
}

/// Nothing where the fast reader gives up.
std::optional<Read> with_plain_reader(const std::string& text) {
    Read read;
    Reporter reporter;
    const Source source(0, text);
    YamlBuilder builder(source, read.nodes_left, reporter);
    if (!read_plain_yaml(source, builder)) return std::nullopt;
    read.complete = true;
    read.outline = outline(builder.take_root());
    read.findings = findings_of(reporter);
    return read;
}

TEST(PlainYaml, ReadsTheUsualForms) {
    constexpr std::string_view kTexts[] = {
        "takt: 1\nlines:\n  - name: a\n    devices:\n      - {name: D1, address: 0x10}\n      - name: 'D "
        "2'\n",
        "a:\n- b\n- c: 1\n  d: 2\n-\n  - e\n  - f\ng: h\n",
        "- - a\n  - b\n- - c\n",
        "# head\na: 1 # one\n\n  # deeper comment\nb: \"two # three\" # four\n# end",
        "a: {b: [1, 2, {c: d}], e: []}\nf: {}\n",
        "a: [1, # one\n    2,\n # two\n\n 3]\nb: {\n  c: 1,\nd: 2}\n",
        "a: 12:30:00\nb: tcp://host:502\nc: x#y\nd: a, b [c] {d} ? ! & *\ne: -5\nf: it's\n",
        "a: ~\nb: null\nc: [NULL, Null, nul]\nd: \"null\"\n",
        "a: \"\"\nb: ''\nc: [\"x, y\", 'z: {']\n",
        "кот: ёж № 5\nё: [ё, 'x ё']\n",
        "a: 1\r\nb:\r\n  - c # d\r\n  - {e: f}\r\n\r\ng: \"h\"\r\n",
        "\xEF\xBB\xBF"
        "a: 1\n",
        "a:   b   \nc:  [ 1 ,  2 ] \nd: { e:  f , g: h }\n",
        // with findings
        "a: 1\nb: {c: 1, c: 2}\na: 2\n",
        "null: 1\nb: 2\n",
        "a: {k1: 1, k2: 1, k3: 1, k4: 1, k5: 1, k6: 1, k7: 1, k8: 1, k9: 1, k10: 1, k11: 1, k12: 1, k13: 1, "
        "k14: 1, k15: 1, k16: 1, k17: 1, k18: 1, k3: 2, k17: 2, k18: 2}\n",
    };
    for (const auto text : kTexts) {
        const auto read = with_plain_reader(std::string(text));
        ASSERT_TRUE(read) << text;
        EXPECT_EQ(read->outline, with_library(std::string(text)).outline) << text;
        EXPECT_EQ(*read, with_library(std::string(text))) << text;
    }
}

TEST(PlainYaml, LeavesOtherFormsToTheLibrary) {
    constexpr std::string_view kTexts[] = {
        "",
        "# nothing\n",
        "text\n",
        "[]",
        "{a: 1}",
        // values that are missing, or go on in the next line
        "a:\n",
        "a:\nb: 1\n",
        "-\n- a\n",
        "a: b\n  c\n",
        "a: 'b\n  c'\n",
        "a: \"b\\n\"\n",
        "a: 'it''s'\n",
        "a:\n  b\n",
        "a:\n  {b: 1}\n",
        "a: [1,\n",
        "a: [b\n  c]\n",
        "a: {b: 1\n}\n",
        "a: [1, ]\n",
        "a: {b}\n",
        "a: {b:1}\n",
        "a: {b:\n 1}\n",
        // indicators
        "a: |\n  b\n",
        "a: >\n  b\n",
        "a: &x 1\n",
        "a: *x\n",
        "a: !t 1\n",
        "a: %b\n",
        "a: @b\n",
        "a: `b\n",
        "? a\n: b\n",
        "'a': 1\n",
        "<<: 1\n",
        "a: - b\n",
        "a: {- b}\n",
        "a: [? b]\n",
        "a: [b?]\n",
        "a: b: c\n",
        "a: b:\n",
        "a: [b: c]\n",
        "a: {b: c: d}\n",
        "a: \"b\" c\n",
        "a: [b] c\n",
        "a: [b]: c\n",
        "a: [b c\n",
        "a: {\"b\": 1}\n",
        "a: [b]#c\n",
        // indentation
        "a: 1\n b: 2\n",
        "  a: 1\nb: 2\n",
        "a:\n    b: 1\n  c: 2\n",
        "- a\nb: 1\n",
        "- a: 1\n b: 2\n",
        "a:\n\tb: 1\n",
        "a:\t1\n",
        "a: b\tc\n",
        "a: 1\n- b\n",
        // documents
        "---\na: 1\n",
        "a: 1\n...\n",
        "a: 1\n---\nb: 2\n",
        "%YAML 1.2\n---\na: 1\n",
        "a: [1,\n---\n2]\n",
    };
    for (const auto text : kTexts) EXPECT_FALSE(with_plain_reader(std::string(text))) << text;
}

TEST(PlainYaml, LeavesTheLimitsToTheLibrary) {
    EXPECT_FALSE(with_plain_reader("a: " + std::string(40, '[') + std::string(40, ']')));
    std::string many;
    for (std::size_t i = 0; i < kNodes; ++i) many += "- a\n";
    EXPECT_FALSE(with_plain_reader(many));
    EXPECT_FALSE(with_plain_reader(std::string(2000, 'k') + ": 1\n"));
    EXPECT_EQ(load_text("p.yaml", "a: " + std::string(40, '[') + std::string(40, ']')).findings.at(0).code,
              "file.too_deep");
}

/// Random texts: pieces of YAML in a random order. Most are faulty, many are read.
class Texts {
public:
    explicit Texts(std::uint32_t seed) : random_(seed) {}

    std::string next() {
        std::string text;
        const std::size_t lines = 1 + number(7);
        for (std::size_t i = 0; i < lines; ++i) text += line();
        if (number(4) == 0) text.pop_back();
        return text;
    }

private:
    std::size_t number(std::size_t count) { return random_() % count; }
    template <std::size_t N>
    std::string one_of(const std::array<std::string_view, N>& all) {
        return std::string(all[number(N)]);
    }

    std::string key() { return one_of(kKeys); }
    std::string scalar() { return one_of(kScalars); }
    std::string flow(std::size_t depth) {
        const bool mapping = number(2) == 0;
        std::string text = mapping ? "{" : "[";
        const std::size_t count = number(4);
        for (std::size_t i = 0; i < count; ++i) {
            if (i > 0) text += one_of(kCommas);
            if (mapping) text += key() + one_of(kColons);
            text += depth < 2 && number(4) == 0 ? flow(depth + 1) : scalar();
        }
        return text + (mapping ? "}" : "]");
    }
    std::string value() { return number(4) == 0 ? flow(0) : scalar(); }
    std::string line() {
        std::string text;
        indent_ = number(3) == 0 ? number(4) : indent_;
        text.append(indent_ * (number(12) == 0 ? 1 : 2), ' ');
        while (number(4) == 0) text += "- ";
        switch (number(8)) {
            case 0: text += value(); break;
            case 1: text += key() + ":"; break;
            case 2: text += one_of(kOdd); break;
            default: text += key() + ": " + value();
        }
        if (number(8) == 0) text += one_of(kEnds);
        return text + (number(20) == 0 ? "\r\n" : "\n");
    }

    static constexpr std::array<std::string_view, 8> kKeys{"a", "b", "cd", "e-f", "g.h/i", "ё", "null", "9"};
    static constexpr std::array<std::string_view, 30> kScalars{
        "1",     "x",    "x y",   "0x10",    "-1",      "-",  "12:30", "x:",  "x: y",         "'q'",
        "\"d\"", "\"\"", "'a b'", "\"\\n\"", "'it''s'", "~",  "null",  "x#y", "x #y",         "ёж",
        "a,b",   "[",    "}",     "?",       "? x",     "&a", "<b",    "(c)", "http://x:1/y", "''"};
    static constexpr std::array<std::string_view, 6> kCommas{", ", ",", ",\n ", ", # c\n  ", " , ", ",\n\n"};
    static constexpr std::array<std::string_view, 4> kColons{": ", ":  ", ":", " : "};
    static constexpr std::array<std::string_view, 10> kOdd{"",       "# comment", "---", "...", "%x",
                                                           "'q': 1", "? a",       "\t",  "- ",  "-"};
    static constexpr std::array<std::string_view, 7> kEnds{" ", "  ", " # c", "#c", " #", "\t", " - "};

    std::mt19937 random_;
    std::size_t indent_ = 0;
};

TEST(PlainYaml, ReadsRandomTextsLikeTheLibrary) {
    Texts texts(1);
    std::size_t read = 0;
    for (int i = 0; i < 30'000; ++i) {
        const auto text = texts.next();
        if (find_foreign(Source(0, text).text())) continue;
        const auto plain = with_plain_reader(text);
        if (!plain) continue;
        ++read;
        ASSERT_EQ(plain->outline, with_library(text).outline) << text;
        ASSERT_EQ(*plain, with_library(text)) << text;
    }
    EXPECT_GT(read, 2000U);
}

}  // namespace
}  // namespace takt::file
