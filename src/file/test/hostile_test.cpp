// Loading any bytes ends with a document or with findings that have their location.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "outline.hpp"
#include "takt/base/utf8.hpp"

namespace takt::file {
namespace hostile_test {

using Findings = std::vector<std::string>;

constexpr std::string_view kProject = R"(# a valid project
takt: 1
lines:
  - name: "rs485-1"
    transport: serial   # or tcp
    port: /dev/ttyUSB0
    devices:
      - name: 'Котёл'
        address: 16
        comment: |
          two
          lines
        variables:
          - {name: Var1, type: float, register: 0, read: 0x03, tags: [a, "b,\n", ~]}
          - name: Pump
            default:
      - name: Second
        variables: boiler.csv
locals:
- {name: go, type: bool}
)";
constexpr std::string_view kTable =
    "name;type;register;read\r\n\"Var 2\";float;\"0x10\";3\r\nVar3;int; 12 ;4\r\n\r\n";

std::string repeat(std::string_view text, std::size_t times) {
    std::string result;
    result.reserve(text.size() * times);
    for (std::size_t i = 0; i < times; ++i) result += text;
    return result;
}

std::size_t lines_of(std::string_view text) {
    return std::size_t(std::ranges::count(text, '\n')) + 1;
}

// The scalars of a document are found in its source at their locations; in a table at least their cell
// is, which may have other words.
void check_places(const model::Node& node, const std::vector<std::vector<std::string_view>>& files) {
    const auto& lines = files[node.location.file];
    RC_ASSERT(node.location.line >= 1 && node.location.line <= lines.size());
    if (node.kind == model::Node::Kind::scalar && !node.quoted && node.text.find('\n') == std::string::npos) {
        auto line = lines[node.location.line - 1];
        for (std::uint32_t column = 1; column < node.location.column; ++column) {
            RC_ASSERT(!line.empty());
            do {
                line.remove_prefix(1);
            } while (!line.empty() && continues_character(line[0]));
        }
        const auto first_word = std::string_view(node.text).substr(0, node.text.find_first_of(" \t"));
        const bool changed = line.starts_with('"') || line.starts_with('!') || line.starts_with('&') ||
                             (node.location.file != 0 && !line.empty());
        if (!changed) RC_ASSERT(line.starts_with(first_word));
    }
    for (const auto& item : node.items) check_places(item, files);
    for (const auto& [key, value] : node.entries) {
        RC_ASSERT(node.find(key.text) == &value);
        check_places(key, files);
        check_places(value, files);
    }
}

std::vector<std::string_view> split(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    std::vector<std::string_view> lines;
    for (;;) {
        const auto end = text.find('\n');
        lines.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return lines;
        text.remove_prefix(end + 1);
    }
}

void check_any(const std::string& project, const std::string& table) {
    const auto loaded =
        load_text("p.yaml", project, [&](const std::string&) -> Result<std::string> { return table; });
    RC_ASSERT(loaded.readable || !loaded.findings.empty());
    RC_ASSERT(loaded.findings.size() <= kMaxFindings);
    locations_and_codes(loaded);
    for (const auto& finding : loaded.findings)
        RC_ASSERT(finding.location.line <= lines_of(finding.location.file == 0 ? project : table));
    std::vector<std::vector<std::string_view>> files(loaded.document.files.size(), split(table));
    files[0] = split(project);
    if (loaded.readable) check_places(loaded.document.root, files);
}

TEST(Hostile, TheValidProjectIsValid) {
    const auto loaded =
        load_text("p.yaml", std::string(kProject),
                  [](const std::string&) -> Result<std::string> { return std::string(kTable); });
    EXPECT_EQ(locations_and_codes(loaded), Findings{});
}

RC_GTEST_PROP(Hostile, RandomBytes, (const std::string& project, const std::string& table)) {
    check_any(project, table);
}

RC_GTEST_PROP(Hostile, RandomYamlCharacters, ()) {
    const auto character = rc::gen::elementOf(std::string("ab: \n-[]{},\"'#&*!|>%@?~\t\\0<\r;"));
    const auto text = rc::gen::container<std::string>(character);
    check_any("lines: [{devices: [{variables: t}]}]\nx:\n " + *text, *text);
    check_any(*text, *text);
}

RC_GTEST_PROP(Hostile, MutatedProjects, ()) {
    std::string texts[] = {std::string(kProject), std::string(kTable)};
    const auto mutations = *rc::gen::inRange(1, 6);
    for (int i = 0; i < mutations; ++i) {
        auto& text = texts[*rc::gen::inRange(0, 2)];
        const auto at = *rc::gen::inRange<std::size_t>(0, text.size() + 1);
        switch (*rc::gen::inRange(0, 4)) {
            case 0: text.resize(at); break;
            case 1: text.erase(at, *rc::gen::inRange<std::size_t>(1, 20)); break;
            case 2:
                text.insert(at, *rc::gen::container<std::string>(
                                    rc::gen::elementOf(std::string("\n\t :-[]{}\"'&*!|,;\xFF\0", 18))));
                break;
            default:
                text.insert(at, text.substr(*rc::gen::inRange<std::size_t>(0, text.size() + 1), 30));
                break;
        }
    }
    check_any(texts[0], texts[1]);
}

TEST(Hostile, EveryPrefixOfAProject) {
    for (std::size_t size = 0; size < kProject.size(); ++size) {
        const auto loaded = load_text("p.yaml", std::string(kProject.substr(0, size)));
        EXPECT_TRUE(loaded.readable || !loaded.findings.empty())
            << size << testing::PrintToString(locations_and_codes(loaded));
    }
}

TEST(Hostile, DepthIsBounded) {
    const std::size_t many = 100'000;
    std::string steps;
    for (std::size_t i = 0; i < 2000; ++i) steps += std::string(i, ' ') + "a:\n";
    for (const auto& text : {repeat("[", many), repeat("{", many), repeat("{a: ", many), repeat("- ", many),
                             repeat("? ", many), repeat("[[", 5 * many), repeat("[{a: ", many), steps}) {
        const auto loaded = load_text("p.yaml", text);
        EXPECT_FALSE(loaded.readable) << text.substr(0, 20);
        ASSERT_EQ(loaded.findings.size(), 1U) << text.substr(0, 20);
        EXPECT_EQ(loaded.findings[0].code, "file.too_deep") << text.substr(0, 20);
        EXPECT_GT(loaded.findings[0].location.line, 0U);
    }
    const auto loaded = load_text("p.yaml", repeat("[", kMaxDepth) + repeat("]", kMaxDepth));
    EXPECT_TRUE(loaded.readable);
}

TEST(Hostile, SizeIsBounded) {
    EXPECT_EQ(locations_and_codes(load_text("p.yaml", std::string(9 << 20, 'a'))), Findings{"0:0 too_large"});
    EXPECT_TRUE(load_text("p.yaml", "a: " + std::string(kMaxFileBytes - 3, 'a')).readable);
    EXPECT_EQ(locations_and_codes(load_text("p.yaml", "[" + repeat("1,", kMaxNodes) + "1]")),
              Findings{"1:2000000 too_many_nodes"});
}

TEST(Hostile, TablesTogetherAreBounded) {
    std::string project = "lines:\n- devices:\n";
    for (int i = 0; i < 12; ++i) project += "  - variables: t" + std::to_string(i) + "\n";
    const std::string blank = "bit\n" + std::string(kMaxFileBytes - 4, ' ');
    const auto loaded =
        load_text("p.yaml", project, [&](const std::string&) -> Result<std::string> { return blank; });
    EXPECT_EQ(locations_and_codes(loaded), (Findings{"11:16 tables_too_large", "12:16 tables_too_large",
                                                     "13:16 tables_too_large", "14:16 tables_too_large"}));
    const auto rows = "bit\n" + repeat("1\n", kMaxNodes / 3 + 1);
    const auto full = load_text("p.yaml", "lines: [{devices: [{variables: t}]}]",
                                [&](const std::string&) -> Result<std::string> { return rows; });
    ASSERT_EQ(full.findings.size(), 1U);
    EXPECT_EQ(full.findings[0].code, "file.too_many_nodes");
}

TEST(Hostile, FindingsAreBounded) {
    const auto loaded = load_text("p.yaml", repeat("a: 1\n", 10'000));
    ASSERT_EQ(loaded.findings.size(), kMaxFindings);
    EXPECT_EQ(loaded.findings.back().code, "file.more_findings");
    EXPECT_EQ(loaded.findings.back().location.line, kMaxFindings + 1);
    const auto long_key = std::string(100'000, 'x');
    const auto twice = load_text("p.yaml", "\"" + long_key + "\": 1\n? " + long_key + "\n: 2\n");
    ASSERT_EQ(twice.findings.size(), 1U);
    EXPECT_LT(twice.findings[0].value.size(), 100U);
}

TEST(Hostile, AliasesDoNotMultiply) {
    std::string laughs = "a0: &a0 [ha, ha, ha, ha, ha, ha, ha, ha, ha]\n";
    for (int i = 1; i < 12; ++i) {
        const auto name = std::to_string(i);
        laughs += "a" + name + ": &a" + name + " [" + repeat("*a" + std::to_string(i - 1) + ",", 9) + "]\n";
    }
    const auto loaded = load_text("p.yaml", laughs);
    EXPECT_EQ(loaded.findings.size(), 12U + 11 * 9);
}

TEST(Hostile, ALongLineCostsNoMoreThanManyShortOnes) {
    const auto loaded = load_text("p.yaml", "[" + repeat("{a: 1},", 100'000) + "]");
    EXPECT_TRUE(loaded.readable);
    EXPECT_EQ(loaded.document.root.items.back().location.column, 2U + 99'999 * 7);
}

}  // namespace hostile_test
}  // namespace takt::file
