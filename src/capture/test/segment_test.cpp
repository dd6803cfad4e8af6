// Packets of every link layer, made byte by byte.
#include "takt/capture/segment.hpp"

#include <gtest/gtest.h>

#include "capture_bytes.hpp"

namespace takt::capture {
namespace segment_test {

using namespace test;

Content decode(LinkType link, const Octets& data, Segment& segment, std::size_t original = 0) {
    const Packet packet{.link = link,
                        .original_length = static_cast<std::uint32_t>(std::max(original, data.size())),
                        .data = data};
    Fragment fragment;
    return decode_segment(packet, segment, fragment);
}

const Octets kIp = ipv4({.sequence = 0x01020304, .acknowledged = 7, .identification = 99}, hex("aa bb"));
const Octets kMacs = hex("00 11 22 33 44 55 00 11 22 33 44 66");

TEST(Segment, OfEveryLinkLayer) {
    const struct {
        const char* what;
        LinkType link;
        Octets header;
    } cases[] = {
        {"ethernet", LinkType::ethernet, joined({kMacs, hex("0800")})},
        {"vlan", LinkType::ethernet, joined({kMacs, hex("8100 0005 0800")})},
        {"qinq", LinkType::ethernet, joined({kMacs, hex("88a8 0005 8100 0006 0800")})},
        {"cooked", LinkType::linux_cooked, hex("0004 0001 0006 000000000000 0000 0800")},
        {"cooked vlan", LinkType::linux_cooked, hex("0004 0001 0006 000000000000 0000 8100 0007 0800")},
        {"cooked 2", LinkType::linux_cooked_2, hex("0800 0000 00000002 0001 04 06 0000000000000000")},
        {"null little", LinkType::null, hex("02000000")},
        {"null big", LinkType::null, hex("00000002")},
        {"loop", LinkType::loop, hex("00000002")},
        {"raw", LinkType::raw, {}},
        {"raw of BSD", LinkType::raw_bsd, {}},
        {"ipv4", LinkType::ipv4, {}},
    };
    for (const auto& [what, link, header] : cases) {
        SCOPED_TRACE(what);
        Segment segment;
        const auto packet = joined({header, kIp, hex("00 00 00")});  // padded to the least Ethernet frame
        ASSERT_EQ(decode(link, packet, segment), Content::segment);
        EXPECT_EQ(segment.source.port, 40000);
        EXPECT_EQ(segment.destination.port, 502);
        EXPECT_EQ(segment.source.address, parse_ip("10.0.0.1"));
        EXPECT_EQ(segment.destination.address, parse_ip("10.0.0.2"));
        EXPECT_EQ(segment.sequence, 0x01020304u);
        EXPECT_EQ(segment.acknowledged, 7u);
        EXPECT_EQ(segment.identification, 99);
        EXPECT_TRUE(segment.ack);
        EXPECT_FALSE(segment.syn || segment.fin || segment.rst);
        EXPECT_EQ(Octets(segment.payload.begin(), segment.payload.end()), hex("aa bb"));
    }
}

Octets ipv6(std::string_view extensions, std::uint8_t next) {
    const auto headers = hex(extensions);
    const Octets tcp(kIp.begin() + 20, kIp.end());
    auto source = hex("fe80 0000 0000 0000 0000 0000 0000 0001");
    auto destination = hex("fe80 0000 0000 0000 0000 0000 0000 0002");
    return joined({hex("60000000"),
                   be(headers.size() + tcp.size(), 2),
                   {next},
                   hex("40"),
                   source,
                   destination,
                   headers,
                   tcp});
}

TEST(Segment, OfIpv6WithExtensionHeaders) {
    for (const auto& packet : {ipv6("", 6), ipv6("06 00 00 00 00 00 00 00", 0),
                               ipv6("3c 00 000000000000 06 01 000000000000 0000000000000000", 43),
                               ipv6("06 00 0000 00000001", 44), ipv6("06 00 00 00 00 00 00 00", 135)}) {
        Segment segment;
        ASSERT_EQ(decode(LinkType::raw, packet, segment), Content::segment);
        EXPECT_EQ(segment.source.address, parse_ip("fe80::1"));
        EXPECT_EQ(segment.destination.port, 502);
        EXPECT_EQ(segment.payload.size(), 2u);
    }
    Segment segment;
    EXPECT_EQ(decode(LinkType::raw, ipv6("06 00 0008 00000001", 44), segment), Content::fragment);
    EXPECT_EQ(decode(LinkType::ipv6, ipv6("", 17), segment), Content::not_tcp);
}

TEST(Segment, PayloadOfACutPacket) {
    Segment segment;
    const Octets cut(kIp.begin(), kIp.end() - 1);
    ASSERT_EQ(decode(LinkType::raw, cut, segment, kIp.size()), Content::segment);
    EXPECT_EQ(segment.payload.size(), 1u);
    EXPECT_EQ(segment.length, 2u);
    for (std::size_t size = 1; size < 40; ++size)
        EXPECT_EQ(decode(LinkType::raw, Octets(kIp.begin(), kIp.begin() + static_cast<std::ptrdiff_t>(size)),
                         segment, kIp.size()),
                  Content::cut)
            << size;
}

TEST(Segment, LengthOfAPacketForSegmentationByTheAdapter) {
    auto packet = kIp;
    packet[2] = packet[3] = 0;
    Segment segment;
    ASSERT_EQ(decode(LinkType::raw, packet, segment), Content::segment);
    EXPECT_EQ(segment.length, 2u);
}

TEST(Segment, OtherContents) {
    Segment segment;
    EXPECT_EQ(decode(LinkType{127}, kIp, segment), Content::other_link);
    EXPECT_EQ(decode(LinkType::ethernet, joined({kMacs, hex("0806 0001")}), segment), Content::not_ip);
    EXPECT_EQ(decode(LinkType::raw, hex("00"), segment), Content::not_ip);
    const auto changed = [](std::size_t at, std::uint8_t value) {
        auto packet = kIp;
        packet[at] = value;
        return packet;
    };
    EXPECT_EQ(decode(LinkType::raw, changed(9, 17), segment), Content::not_tcp);
    EXPECT_EQ(decode(LinkType::raw, changed(6, 0x20), segment), Content::fragment);
    EXPECT_EQ(decode(LinkType::raw, changed(7, 0x10), segment), Content::fragment);
    EXPECT_EQ(decode(LinkType::raw, changed(0, 0x44), segment), Content::malformed);
    EXPECT_EQ(decode(LinkType::raw, changed(32, 0x40), segment), Content::malformed);
    EXPECT_EQ(decode(LinkType::raw, changed(32, 0xF0), segment), Content::malformed);
}

TEST(Segment, FragmentsHaveTheirPlace) {
    auto packet = kIp;
    packet[6] = 0x20;
    packet[7] = 0x02;
    Segment segment;
    Fragment fragment;
    const Packet captured{
        .link = LinkType::raw, .original_length = static_cast<std::uint32_t>(packet.size()), .data = packet};
    ASSERT_EQ(decode_segment(captured, segment, fragment), Content::fragment);
    EXPECT_EQ(fragment.source, parse_ip("10.0.0.1"));
    EXPECT_EQ(fragment.identification, 99u);
    EXPECT_EQ(fragment.offset, 16u);
    EXPECT_TRUE(fragment.more);
    EXPECT_EQ(fragment.payload.size(), 22u);
    EXPECT_EQ(decode_datagram(fragment, fragment.payload, segment), Content::segment);
    EXPECT_EQ(segment.destination.port, 502);
    const auto version6 = ipv6("06 00 0019 0000002a", 44);
    const Packet other{.link = LinkType::raw,
                       .original_length = static_cast<std::uint32_t>(version6.size()),
                       .data = version6};
    ASSERT_EQ(decode_segment(other, segment, fragment), Content::fragment);
    EXPECT_EQ(fragment.destination, parse_ip("fe80::2"));
    EXPECT_EQ(fragment.identification, 42u);
    EXPECT_EQ(fragment.offset, 24u);
    EXPECT_TRUE(fragment.more);
    EXPECT_EQ(fragment.payload.size(), 22u);
}

}  // namespace segment_test
}  // namespace takt::capture
