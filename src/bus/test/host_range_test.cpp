#include "takt/bus/host_range.hpp"

#include <gtest/gtest.h>

namespace takt::bus {
namespace host_range_test {

constexpr std::uint32_t ip(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    return a << 24U | b << 16U | c << 8U | d;
}

TEST(HostRange, ReadsRangesAndNetworks) {
    const struct {
        const char* text;
        HostRange range;
    } cases[] = {
        {"10.0.0.8-9", {ip(10, 0, 0, 8), ip(10, 0, 0, 9)}},
        {"10.0.0.254-10.0.1.1", {ip(10, 0, 0, 254), ip(10, 0, 1, 1)}},
        {"10.0.0.9/30", {ip(10, 0, 0, 9), ip(10, 0, 0, 10)}},
        {"10.0.0.9/31", {ip(10, 0, 0, 8), ip(10, 0, 0, 9)}},
        {"10.0.0.9/32", {ip(10, 0, 0, 9), ip(10, 0, 0, 9)}},
        {"192.168.1.77/24", {ip(192, 168, 1, 1), ip(192, 168, 1, 254)}},
        {"255.255.255.254-255", {ip(255, 255, 255, 254), ip(255, 255, 255, 255)}},
    };
    for (const auto& [text, range] : cases) EXPECT_EQ(parse_host_range(text).value(), range) << text;
}

TEST(HostRange, OneHostIsNoRange) {
    for (const char* text : {"10.0.0.1", "plc-7", "my-gateway.local", "", "::1", "10.0.0-5", "010.0.0.1-5",
                             "10.0.0.1.1-5", "256.0.0.1-5"})
        EXPECT_EQ(parse_host_range(text).value(), std::nullopt) << text;
}

TEST(HostRange, RefusesBrokenAndHugeRanges) {
    for (const char* text :
         {"10.0.0.9-1", "10.0.0.9-256", "10.0.0.9/33", "10.0.0.9/", "10.0.0.9-", "10.0.0.9-x", "10.0.0.9/-1"})
        EXPECT_EQ(parse_host_range(text).error().code, Code::syntax) << text;
    EXPECT_EQ(parse_host_range("10.0.0.9-1").error().subject.view(), "10.0.0.9-1 → 10.0.0.9-254");
    EXPECT_EQ(parse_host_range("10.0.0.0/8").error(),
              fail(Code::out_of_range, "10.0.0.0/8", (1 << 24) - 2, 1, kMaxScanTargets).error());
    EXPECT_EQ(parse_host_range("0.0.0.0/0").error().code, Code::out_of_range);
    EXPECT_TRUE(parse_host_range("10.0.0.0/20")) << "4094 hosts";
}

TEST(HostRange, TheHostOfAUrl) {
    const auto range = parse_url_range("tcp://10.0.0.254-10.0.1.1:1502").value();
    ASSERT_TRUE(range);
    EXPECT_EQ(range->hosts.size(), 4U);
    EXPECT_EQ(range->first_url, "tcp://10.0.0.254:1502");
    EXPECT_EQ(parse_url_range("rtu+tcp://10.0.0.8-9").value()->first_url, "rtu+tcp://10.0.0.8");
    for (const char* url : {"tcp://host-1:502", "tcp://[::1]:1502", "rtu:///dev/ttyS0-5", "nonsense", ""})
        EXPECT_FALSE(parse_url_range(url).value()) << url;
    EXPECT_EQ(parse_url_range("tcp://10.0.0.9/").error().code, Code::syntax);
}

TEST(HostRange, AddressesAsText) {
    EXPECT_EQ(ipv4_text(0), "0.0.0.0");
    EXPECT_EQ(ipv4_text(ip(192, 168, 0, 1)), "192.168.0.1");
    EXPECT_EQ(ipv4_text(0xFFFFFFFFU), "255.255.255.255");
}

}  // namespace host_range_test
}  // namespace takt::bus
