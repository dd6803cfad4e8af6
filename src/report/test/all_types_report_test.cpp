#include "takt/report/states/all_types_report.hpp"

#include <gtest/gtest.h>

#include <array>

#include "sample.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace all_types_report_test {

using namespace test;

// 21.5 as ABCD, then -70000 as ABCD.
constexpr std::array<std::uint16_t, 4> kRegisters{0x41AC, 0x0000, 0xFFFE, 0xEE90};

const client::ReadSpec kSpec{.start = 10, .count = 4};

/// The value of an entry of "values".
std::string value_of(const file::Json& json, int address, std::string_view type, std::string_view order) {
    for (std::size_t i = 0; i < size_of(at(json, "values")); ++i) {
        const auto& entry = at(json, "values", i);
        if (at(entry, "address").dump() == std::to_string(address) &&
            at(entry, "type").dump() == '"' + std::string(type) + '"' &&
            at(entry, "order").dump() == '"' + std::string(order) + '"')
            return at(entry, "value").dump();
    }
    return "missing";
}

TEST(AllTypesReport, EveryTypeInEveryOrder) {
    const auto json = all_types_json(english(), {}, kSpec, kRegisters, {});
    const struct {
        int address;
        const char* type;
        const char* order;
        const char* value;
    } cases[] = {{10, "uint16", "AB", "16812"},
                 {10, "uint16", "BA", "44097"},
                 {12, "int16", "AB", "-2"},
                 {10, "float", "ABCD", "21.5"},
                 {11, "uint32", "ABCD", "65534"},
                 {11, "uint32", "CDAB", "4294836224"},
                 {11, "uint32", "BADC", "65279"},
                 {11, "uint32", "DCBA", "4278124544"},
                 {12, "int32", "ABCD", "-70000"},
                 {10, "int64", "ABCDEFGH", "4732157312754445968"},
                 {10, "uint64", "HGFEDCBA", "10443564957088918593"}};
    for (const auto& [address, type, order, value] : cases)
        EXPECT_EQ(value_of(json, address, type, order), value) << address << ' ' << type << ' ' << order;
    EXPECT_EQ(size_of(at(json, "values")), 4U * 4 + 3 * 12 + 1 * 12 + 2);
    EXPECT_EQ(at(json, "registers", 2).dump(), R"({"address":12,"hex":"FFFE","binary":"1111111111111110"})");
    EXPECT_JSON(at(json, "type"), "all");
}

TEST(AllTypesReport, TablesFit80Columns) {
    for (const auto language : kLanguages) {
        const auto text = all_types_text(Texts(language), 10, kRegisters);
        expect_complete(text);
        for (const auto* part :
             {"41AC  0100 0001 1010 1100", "10..11", "12..13", "10..13", "ABCD 4321, CDAB 2143",
              "AB 21, BA 12", "GHEFCDAB 21436587", "string AB  A\\xAC"})
            expect_contains(text, part);
        for (std::size_t begin = 0; begin < text.size();) {
            const auto end = text.find('\n', begin);
            EXPECT_LE(display_width(text.substr(begin, end - begin)), 80U) << text.substr(begin, end - begin);
            begin = end + 1;
        }
    }
}

TEST(AllTypesReport, ShowsTheTypesThatFitTheRange) {
    const std::span<const std::uint16_t> all(kRegisters);
    const auto one = all_types_text(english(), 7, all.first(1));
    EXPECT_EQ(one.find("float"), std::string::npos);
    expect_contains(one, "string BA");
    EXPECT_EQ(all_types_text(english(), 7, all.first(3)).find("double"), std::string::npos);
    EXPECT_EQ(all_types_text(english(), 7, {}), "");
    const std::vector<std::uint16_t> many(300, 0x4142);
    expect_contains(all_types_text(english(), 0, many), "296..299");
}

}  // namespace all_types_report_test
}  // namespace takt::report
