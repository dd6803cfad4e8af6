#include "role.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "certificates.hpp"

namespace takt::tls {
namespace role_test {

using Der = std::vector<std::uint8_t>;

TEST(Role, IsOneWholeUtf8String) {
    struct Case {
        Der der;
        std::string_view role;
    };
    const std::string longest(kLongestRole, 'x');
    const Case cases[] = {
        {utf8_string("Operator"), "Operator"},
        {utf8_string("Оператор"), "Оператор"},
        {utf8_string(longest), longest},
        {utf8_string(longest + "x"), ""},
        {utf8_string(""), ""},
        {{}, ""},
        {{0x0C}, ""},
        {{0x0C, 0x81}, ""},
        {{0x0C, 0x81, 0x01, 'a'}, ""},         // not the shortest form
        {{0x0C, 0x80, 'a', 0, 0}, ""},         // indefinite length is not DER
        {{0x0C, 0x82, 0x00, 0x01, 'a'}, ""},   // two bytes of length
        {{0x0C, 0x20, 'A'}, ""},               // cut
        {{0x0C, 0x01, 'A', 'B'}, ""},          // something behind it
        {{0x13, 0x01, 'A'}, ""},               // PrintableString
        {{0x0C, 0x03, 'A', 0x00, 'B'}, ""},    // NUL
        {{0x0C, 0x02, 'A', '\n'}, ""},         // control character
        {{0x0C, 0x02, 0xC3, 0x28}, ""},        // no UTF-8
        {{0x0C, 0x03, 0xE2, 0x80, 0xAE}, ""},  // right-to-left override
    };
    for (const auto& [der, role] : cases) EXPECT_EQ(role_text(der), role) << testing::PrintToString(der);
}

TEST(Role, OfACertificateWithExactlyOne) {
    const auto role = [](const std::vector<Der>& roles) {
        return role_of(*make({.usage = "clientAuth", .roles = roles}).certificate);
    };
    EXPECT_EQ(role({}), "");
    EXPECT_EQ(role({utf8_string("Operator")}), "Operator");
    EXPECT_EQ(role({utf8_string("Operator"), utf8_string("Engineer")}), "");
    EXPECT_EQ(role({utf8_string("Operator"), utf8_string("Operator")}), "");
    EXPECT_EQ(role({{0x0C, 0x20, 'A'}}), "");
}

}  // namespace role_test
}  // namespace takt::tls
