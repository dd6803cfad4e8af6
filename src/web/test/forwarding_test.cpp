#include "http/forwarding.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::web {
namespace forwarding_test {

TEST(Forwarding, TheRightmostAddressThatIsNoProxyIsTheClient) {
    struct Case {
        const char* peer;
        const char* addresses;
        const char* client;
    };
    const std::vector<Case> cases{
        // The peer is a proxy.
        {"10.0.0.1", "192.0.2.7", "192.0.2.7"},
        {"10.0.0.1", "198.51.100.1, 192.0.2.7", "192.0.2.7"},
        {"10.0.0.1", "192.0.2.7,10.9.0.2", "192.0.2.7"},
        {"10.0.0.1", " 192.0.2.7 ,\t10.9.0.2 , 10.0.0.1", "192.0.2.7"},
        {"10.0.0.1", "10.9.0.3, 10.9.0.2", "10.9.0.3"},
        {"10.0.0.1", "192.0.2.7:4711", "192.0.2.7"},
        {"10.0.0.1", "2001:db8::7", "2001:db8::7"},
        {"10.0.0.1", "[2001:db8::7]:4711", "2001:db8::7"},
        {"10.0.0.1", "[2001:db8::7]", "2001:db8::7"},
        {"[fd00::1]", "192.0.2.7", "192.0.2.7"},
        {"10.0.0.1", "", "10.0.0.1"},
        {"10.0.0.1", ",", "10.0.0.1"},
        {"10.0.0.1", "unknown", "10.0.0.1"},
        {"10.0.0.1", "192.0.2.7, unknown", "10.0.0.1"},
        {"10.0.0.1", "192.0.2.7, _hidden, 10.9.0.2", "10.9.0.2"},
        {"10.0.0.1", "192.0.2.7, [", "10.0.0.1"},
        {"10.0.0.1", "fe80::7%made-up", "fe80::7"},
        // It is not.
        {"10.0.0.2", "192.0.2.7", "10.0.0.2"},
        {"[fd00::2]", "192.0.2.7", "[fd00::2]"},
        {"", "192.0.2.7", ""},
    };
    const std::vector<Network> proxies{*parse_network("10.0.0.1"), *parse_network("10.9.0.0/16"),
                                       *parse_network("fd00::1")};
    for (const auto& its : cases)
        EXPECT_EQ(forwarded_client(its.peer, {.addresses = its.addresses}, proxies).address, its.client)
            << its.peer << " | " << its.addresses;
}

TEST(Forwarding, OnlyProxiesReportHostAndScheme) {
    const std::vector<Network> proxies{*parse_network("10.0.0.1")};
    const ForwardingFields fields{
        .addresses = "192.0.2.7", .host = "made.up, plant.example.com", .scheme = "http, HTTPS"};
    const auto known = forwarded_client("10.0.0.1", fields, proxies);
    EXPECT_EQ(known.host, "plant.example.com");
    EXPECT_TRUE(known.tls);
    const auto other = forwarded_client("10.0.0.2", fields, proxies);
    EXPECT_EQ(other.host, "");
    EXPECT_FALSE(other.tls);
    EXPECT_FALSE(forwarded_client("10.0.0.1", {.scheme = "https, http"}, proxies).tls);
}

TEST(Forwarding, AnIpv6NetworkIsOneKey) {
    EXPECT_EQ(limit_key("[2001:db8::7]"), limit_key("2001:db8::8"));
    EXPECT_NE(limit_key("2001:db8::7"), limit_key("2001:db8:0:1::7"));
    EXPECT_NE(limit_key("192.0.2.7"), limit_key("192.0.2.8"));
    EXPECT_EQ(limit_key("::ffff:192.0.2.7"), limit_key("192.0.2.7"));
    EXPECT_EQ(limit_key("pipe"), "pipe");
}

}  // namespace forwarding_test
}  // namespace takt::web
