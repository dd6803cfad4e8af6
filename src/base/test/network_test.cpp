#include "takt/base/network.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>

namespace takt {
namespace network_test {

std::string text_of(const IpAddress& address) {
    char text[INET6_ADDRSTRLEN] = {};
    return ::inet_ntop(AF_INET6, address.bytes.data(), text, sizeof text);
}

TEST(Network, NearbyAddressesAreLoopbackPrivateAndLinkLocal) {
    for (const auto* text :
         {"127.0.0.1", "127.255.0.1", "10.1.2.3", "172.16.0.1", "172.31.255.255", "192.168.0.7",
          "169.254.1.1", "::1", "fc00::1", "fdff::1", "fe80::1%eth0", "febf::1", "::ffff:10.0.0.1"})
        EXPECT_TRUE(parse_ip(text)->is_nearby()) << text;
    for (const auto* text :
         {"126.0.0.1", "11.0.0.1", "172.15.0.1", "172.32.0.1", "192.169.0.1", "169.253.1.1", "0.0.0.0",
          "::", "::2", "fb00::1", "fe00::1", "fec0::1", "2001:db8::1", "192.0.2.1"})
        EXPECT_FALSE(parse_ip(text)->is_nearby()) << text;
}

TEST(Network, ReadsAddresses) {
    const std::pair<const char*, const char*> rows[] = {
        {"192.0.2.7", "::ffff:192.0.2.7"},
        {"::", "::"},
        {"::1", "::1"},
        {"2001:db8::1", "2001:db8::1"},
        {"2001:DB8:0:0:0:0:0:1", "2001:db8::1"},
        {"fe80::1%eth0", "fe80::1"},
        {"::ffff:10.0.0.1", "::ffff:10.0.0.1"},
        {"64:ff9b::192.0.2.33", "64:ff9b::c000:221"},
        {"1:2:3:4:5:6:7::", "1:2:3:4:5:6:7:0"},
    };
    for (const auto& [text, expected] : rows) {
        const auto address = parse_ip(text);
        ASSERT_TRUE(address) << text;
        EXPECT_EQ(text_of(*address), expected) << text;
    }
}

TEST(Network, RefusesWhatIsNone) {
    for (const char* text : {"",        "1.2.3",   "1.2.3.4.5", "256.1.1.1",         "1.2.3.",
                             ".1.2.3",  "1..2.3",  "0x1.2.3.4", "01.2.3.4",          " 1.2.3.4",
                             "a",       ":",       ":::",       "1:2:3:4:5:6:7:8:9", "1:2:3:4:5:6:7",
                             "1::2::3", "12345::", "g::",       "1:2:3:4:5:6:7:8::", "1:",
                             ":1",      "::1.2.3", "1.2.3.4:5", "+1.2.3.4",          "-1.2.3.4"})
        EXPECT_FALSE(parse_ip(text)) << text;
    for (const char* text : {"1.2.3.4/33", "1.2.3.4/", "1.2.3.4/-1", "::/129", "/8", "1.2.3.4/8/8", "::/x"})
        EXPECT_FALSE(parse_network(text)) << text;
}

TEST(Network, ReadsPeers) {
    EXPECT_EQ(parse_peer("192.0.2.7:50100"), parse_ip("192.0.2.7"));
    EXPECT_EQ(parse_peer("[2001:db8::1]:50100"), parse_ip("2001:db8::1"));
    EXPECT_EQ(parse_peer("[::ffff:192.0.2.7]:1"), parse_ip("192.0.2.7"));
    for (const char* text : {"/dev/ttyUSB0", "", "/dev/serial/by-id/a:b"})
        EXPECT_FALSE(parse_peer(text)) << text;
}

TEST(Network, ContainsByItsBits) {
    struct Row {
        const char* network;
        const char* address;
        bool inside;
    };
    const Row rows[] = {
        {"192.0.2.0/24", "192.0.2.255", true},
        {"192.0.2.0/24", "192.0.3.0", false},
        {"192.0.2.128/25", "192.0.2.127", false},
        {"192.0.2.128/25", "192.0.2.128", true},
        {"192.0.2.7", "192.0.2.7", true},
        {"192.0.2.7", "192.0.2.6", false},
        {"0.0.0.0/0", "8.8.8.8", true},
        {"0.0.0.0/0", "2001:db8::1", false},
        {"::/0", "8.8.8.8", false},
        {"::/0", "2001:db8::1", true},
        {"2001:db8::/33", "2001:db8:7fff::", true},
        {"2001:db8::/33", "2001:db8:8000::", false},
        {"192.0.2.99/24", "192.0.2.1", true},
        {"::/0", "::1", true},
        {"::/0", "::ffff:192.0.2.1", false},
        {"::ffff:0:0/95", "192.0.2.1", false},
        {"::ffff:0:0/96", "192.0.2.1", true},
    };
    for (const auto& [network, address, inside] : rows)
        EXPECT_EQ(parse_network(network)->contains(*parse_ip(address)), inside) << network << ' ' << address;
}

RC_GTEST_PROP(Network, ReadsAddressesAsTheSystemDoes, ()) {
    const auto text = *rc::gen::container<std::string>(rc::gen::elementOf(std::string("0123456789af:::.")));
    IpAddress address;
    unsigned char ipv4[4];
    const bool six = ::inet_pton(AF_INET6, text.c_str(), address.bytes.data()) == 1;
    const bool four = ::inet_pton(AF_INET, text.c_str(), ipv4) == 1;
    const auto parsed = parse_ip(text);
    RC_TAG(six || four);
    if (six) {
        RC_ASSERT(parsed.has_value());
        RC_ASSERT(parsed->bytes == address.bytes);
    }
    if (four) RC_ASSERT(parsed.has_value() && parsed->is_ipv4());
    if (!six && !four) RC_ASSERT(!parsed.has_value());
}

}  // namespace network_test
}  // namespace takt
