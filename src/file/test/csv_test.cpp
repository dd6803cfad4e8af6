#include <gtest/gtest.h>

#include "outline.hpp"

namespace takt::file {
namespace csv_test {

using Findings = std::vector<std::string>;

constexpr std::string_view kProject = "lines: [{devices: [{variables: t.csv}]}]\n";

// The table as the only one of a project in `folder`.
Loaded load_table(std::string_view table) {
    return load_text("folder/p.yaml", std::string(kProject),
                     [&](const std::string& path) -> Result<std::string> {
                         EXPECT_EQ(path, "folder/t.csv");
                         return std::string(table);
                     });
}

const model::Node& variables(const Loaded& loaded) {
    return loaded.document.root.entries[0].value.items[0].entries[0].value.items[0].entries[0].value;
}

TEST(Csv, RowsBecomeMappings) {
    struct Case {
        std::string_view text;
        std::string_view outline;
    };
    constexpr Case kCases[] = {
        {"type,register\nfloat,0x10\nint,2",
         "[{type@1/1:1: float@1/2:1, register@1/1:6: 0x10@1/2:7}@1/2:1, "
         "{type@1/1:1: int@1/3:1, register@1/1:6: 2@1/3:5}@1/3:1]@1/1:1"},
        {"\xEF\xBB\xBF"
         "type;bit\r\nbool;\r\n;3\r\n",
         "[{type@1/1:1: bool@1/2:1}@1/2:1, {bit@1/1:6: 3@1/3:2}@1/3:1]@1/1:1"},
        {"type,bit\n\n,,\nbool,1,,\n , \n", "[{type@1/1:1: bool@1/4:1, bit@1/1:6: 1@1/4:6}@1/4:1]@1/1:1"},
        {" type , bit\n\tbool ,  1 \n", "[{type@1/1:2: bool@1/2:2, bit@1/1:9: 1@1/2:10}@1/2:2]@1/1:1"},
        // in quotes: separators, doubled quotes and line breaks; elsewhere a quote is a character like others
        {"\"name\",\"bit\"\n\"a,\"\"b\"\"\nc\" , \"3\"\nd,4\n",
         "[{\"name\"@1/1:1: \"a,\"b\"\nc\"@1/2:1, \"bit\"@1/1:8: \"3\"@1/3:6}@1/2:1, "
         "{\"name\"@1/1:1: d@1/4:1, \"bit\"@1/1:8: 4@1/4:3}@1/4:1]@1/1:1"},
        {"reference;comment\n40108;12\" pipe\n",
         "[{reference@1/1:1: 40108@1/2:1, comment@1/1:11: 12\" pipe@1/2:7}@1/2:1]@1/1:1"},
        {"\"bit;\",read\n1,2\n", "[{\"bit\"@1/1:1: 1@1/2:1, read@1/1:8: 2@1/2:3}@1/2:1]@1/1:1"},
        {"name,bit\nнасос,1\n", "[{name@1/1:1: насос@1/2:1, bit@1/1:6: 1@1/2:7}@1/2:1]@1/1:1"},
        {"type", "[]@1/1:1"},
    };
    for (const auto& [text, expected] : kCases) {
        const auto loaded = load_table(text);
        EXPECT_EQ(outline(variables(loaded)), expected) << text;
        EXPECT_EQ(locations_and_codes(loaded), Findings{}) << text;
        EXPECT_EQ(loaded.document.files, (std::vector<std::string>{"folder/p.yaml", "folder/t.csv"}));
    }
}

TEST(Csv, DamagedRowsAreLeftOutAndReported) {
    struct Case {
        std::string_view text;
        std::string_view outline;
        Findings findings;
    };
    const Case cases[] = {
        {"", "[]@1/1:1", {"1/1:1 csv.no_header"}},
        {"\n , \n", "[]@1/1:1", {"1/1:1 csv.no_header"}},
        {"Alarm,bool,0x01,none,17\nLevel,float,3,none,20\n", "[]@1/1:1", {"1/1:1 csv.no_header"}},
        {"\n1,2\n3,4\n", "[]@1/1:1", {"1/2:1 csv.no_header"}},
        {"bit\n1,2\n3\n4,,5\n",
         "[{bit@1/1:1: 3@1/3:1}@1/3:1]@1/1:1",
         {"1/2:3 csv.too_many_cells", "1/4:4 csv.too_many_cells"}},
        {"bit,type,bit\n1,,2\n", "[{bit@1/1:1: 1@1/2:1}@1/2:1]@1/1:1", {"1/1:10 csv.duplicate_column"}},
        {"bit,,type\n1,,x\n2,y,\n",
         "[{bit@1/1:1: 1@1/2:1, type@1/1:6: x@1/2:4}@1/2:1]@1/1:1",
         {"1/3:3 csv.no_column_name"}},
        {"bit\n\"1\"2\n3\n\"4\n5\n",
         "[{bit@1/1:1: 3@1/3:1}@1/3:1]@1/1:1",
         {"1/2:4 csv.after_quote", "1/4:1 csv.unclosed_quote"}},
        {"\"bit\n1\n", "[]@1/1:1", {"1/1:1 csv.unclosed_quote"}},
        {"name\n\xD2\xD0\xB5\xE5\xD0\xB5\n", "[]@1:32", {"1/2:1 not_utf8"}},
        {"\xEF\xBB\xBFname\n\xD2\xE5\n", "[]@1:32", {"1/2:1 not_utf8"}},
        {"name\n\xE5\x98\n", "[]@1:32", {"1/2:2 not_cp1251"}},
        {std::string_view("name\n\xD2\0\n", 8), "[]@1:32", {"1/2:2 control_character"}},
    };
    for (const auto& [text, expected, findings] : cases) {
        const auto loaded = load_table(text);
        EXPECT_EQ(outline(variables(loaded)), expected) << text;
        EXPECT_EQ(locations_and_codes(loaded), findings) << text;
        EXPECT_TRUE(loaded.readable);
    }
}

TEST(Csv, HasABoundOnItsColumns) {
    const auto loaded = load_table(std::string(1'000'000, ','));
    EXPECT_EQ(locations_and_codes(loaded), Findings{"1/1:1 csv.no_header"});
    std::string wide = "a";
    for (int i = 0; i < 300; ++i) wide += ",a" + std::to_string(i);
    EXPECT_EQ(locations_and_codes(load_table(wide)), Findings{"1/1:1 csv.too_many_columns"});
    std::string trailing = "name";
    for (int i = 0; i < 100'000; ++i) trailing += ';';
    EXPECT_EQ(locations_and_codes(load_table(trailing + "\nA" + std::string(1000, ';') + "\n")), Findings{});
    EXPECT_EQ(locations_and_codes(load_table(trailing + "\nA" + std::string(1000, ';') + "B\n")),
              Findings{"1/2:1002 csv.too_many_cells"});
    EXPECT_EQ(locations_and_codes(load_table("bit\n" + std::string(1'000'000, ',') + "\n1\n")), Findings{});
}

TEST(Csv, TablesThatCannotBeHadArePlacedAtTheirName) {
    const std::string project =
        "lines:\n- devices:\n  - {variables: a.csv}\n  - {variables: /b.csv}\n  - {variables: ./x/../a.csv}\n"
        "  - {variables: [1]}\n  - {variables: c.csv}\n- {}\n- devices: {}\n";
    const auto loaded = load_text("p.yaml", project, [](const std::string& path) -> Result<std::string> {
        if (path == "c.csv") return "bit\n1\n";
        return fail(Code::cannot_open, path, path == "/b.csv" ? EACCES : ENOENT);
    });
    EXPECT_EQ(locations_and_codes(loaded),
              (Findings{"3:17 not_found", "4:17 no_permission", "5:17 table_twice"}));
    EXPECT_EQ(loaded.findings[1].value, "/b.csv");
    EXPECT_EQ(loaded.findings[1].path, "lines[0].devices[1].variables");
    EXPECT_EQ(loaded.document.files, (std::vector<std::string>{"p.yaml", "c.csv"}));
    EXPECT_TRUE(loaded.readable);
    EXPECT_TRUE(
        outline(loaded.document.root)
            .starts_with(
                "{lines@1:1: [{devices@2:3: [{variables@3:6: []@3:17}@3:5, {variables@4:6: []@4:17}@4:5"))
        << outline(loaded.document.root);
}

}  // namespace csv_test
}  // namespace takt::file
