#include "takt/model/byte_order.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "findings_text.hpp"

namespace takt::model::test {
namespace byte_order_test {

TEST(ByteOrders, ByteOrder) {
    const Case devices[] = {
        {"{byte_order: \"2143\"}", ""},
        {"{byte_order: 4321}", ""},
        {"{byte_order: 2 1 4 3}", ""},
        {"{byte_order: \"Float: 2 1 4 3\"}", ""},
        {"{byte_order: 12, high_register_first: true}", ""},
        {"{byte_order: 78563412, high_byte_first: false, high_register_first: true}", ""},
        {"{byte_order: 2413}",
         "byte_order.unknown byte_order=2413 [2143, 4321, 1234, 3412, 21, 12, 21436587, 87654321, 12345678, "
         "78563412]"},
        {"{byte_order: [2, 1]}",
         "field.not_a_value byte_order= [2143, 4321, 1234, 3412, 21, 12, 21436587, 87654321, 12345678, "
         "78563412]"},
        {"{byte_order: 2143, high_byte_first: false}",
         "byte_order.contradiction high_byte_first=false [true]"},
        {"{byte_order: 2143, high_register_first: true}",
         "byte_order.contradiction high_register_first=true [false]"},
        {"{byte_order: 12, high_byte_first: true}", "byte_order.contradiction high_byte_first=true [false]"},
    };
    for (const auto& [keys, expected] : devices) EXPECT_EQ(findings_text({.device = keys}), expected) << keys;
    const Case variables[] = {
        {"{byte_order: 1234}", ""},
        {"{byte_order: 12}", ""},
        {"{byte_order: 12345678}", "byte_order.type byte_order=12345678 [2143, 4321, 1234, 3412, 21, 12]"},
        {"{type: float, byte_order: 12}", "byte_order.type byte_order=12 [2143, 4321, 1234, 3412]"},
        {"{type: double, byte_order: 12345678}", ""},
        {"{type: double, byte_order: 21}",
         "byte_order.type byte_order=21 [2143, 4321, 1234, 3412, 21436587, 87654321, 12345678, 78563412]"},
        {"{type: string, length: 4, byte_order: 12}", ""},
    };
    for (const auto& [keys, expected] : variables)
        EXPECT_EQ(findings_text({.variable = keys}), expected) << keys;
}

TEST(ByteOrders, ByteOrdersByTheLettersThatPeopleUse) {
    constexpr std::pair<std::string_view, std::string_view> kNames[] = {
        {"ABCD", "4321"},   {"CDAB", "2143"}, {"BADC", "3412"},         {"DCBA", "1234"},
        {"AB", "21"},       {"ba", "12"},     {"ABCDEFGH", "87654321"}, {"GHEFCDAB", "21436587"},
        {"C D A B", "2143"}};
    for (const auto& [letters, digits] : kNames) {
        const auto named = parse_byte_order(letters);
        const auto numbered = parse_byte_order(digits);
        ASSERT_TRUE(named) << letters;
        EXPECT_EQ(named->order, numbered->order) << letters;
        EXPECT_EQ(named->bytes, numbered->bytes) << letters;
    }
    for (const auto* const wrong : {"ABDC", "A", "ABCE", "AACC", "ABCDEFGHI", "", "A1", "Float"})
        EXPECT_FALSE(parse_byte_order(wrong)) << wrong;
}

TEST(ByteOrders, TheByteOrderOfAVariableIsItsOwnOrItsDevices) {
    struct Orders {
        std::string_view device;
        std::string_view variable;
        std::string_view expected;
    };
    constexpr Orders kCases[] = {
        {"{}", "{}", "2143"},
        {"{byte_order: 4321}", "{}", "4321"},
        {"{byte_order: 4321}", "{high_register_first: false}", "2143"},
        {"{high_register_first: true}", "{byte_order: 1234}", "1234"},
        {"{byte_order: 12}", "{}", "1234"},
        {"{byte_order: 87654321}", "{}", "4321"},
        {"{high_byte_first: false}", "{byte_order: 3412}", "3412"},
    };
    for (const auto& [device, variable, expected] : kCases) {
        const auto typed = "{type: float" + std::string(variable == "{}" ? "}" : ", ") +
                           std::string(variable == "{}" ? "" : variable.substr(1));
        const auto checked = interpret(document({.device = device, .variable = typed}));
        EXPECT_EQ(findings_text(checked), "");
        const auto& read = checked.project.lines.at(0).devices.at(0).variables.at(0);
        EXPECT_EQ(byte_order_text(read.order, read.type), expected) << device << variable;
    }
    EXPECT_EQ(byte_order_text({.high_byte_first = false, .high_register_first = true}, DataType::int64),
              "78563412");
    EXPECT_EQ(byte_order_text({.high_byte_first = false}, DataType::string), "12");
}

TEST(ByteOrders, ByteOrderOfACoil) {
    const std::string order = "byte_order: \"2143\"";
    EXPECT_EQ(findings_text({.variable = "{type: bool, read: 0x01, bit: 1, " + order + "}"}),
              "?field.without_effect byte_order=2143");
    EXPECT_EQ(findings_text({.variable = "{type: bool, read: 0x03, bit: 1, " + order + "}"}), "");
}

TEST(ByteOrder, EveryPermutationHasAName) {
    const std::pair<const char*, const char*> names[] = {{"4321", "ABCD"},
                                                         {"2143", "CDAB"},
                                                         {"3412", "BADC"},
                                                         {"1234", "DCBA"},
                                                         {"21", "AB"},
                                                         {"12", "BA"},
                                                         {"87654321", "ABCDEFGH"},
                                                         {"21436587", "GHEFCDAB"},
                                                         {"78563412", "BADCFEHG"},
                                                         {"12345678", "HGFEDCBA"}};
    for (const auto& [digits, letters] : names) {
        EXPECT_EQ(byte_order_name(digits), letters);
        const auto by_name = parse_byte_order(letters);
        const auto by_digits = parse_byte_order(digits);
        ASSERT_TRUE(by_name && by_digits) << letters;
        EXPECT_EQ(by_name->order, by_digits->order) << letters;
        EXPECT_EQ(by_name->bytes, by_digits->bytes) << letters;
    }
    EXPECT_EQ(std::size(names), kByteOrders.size());
}

}  // namespace byte_order_test
}  // namespace takt::model::test
