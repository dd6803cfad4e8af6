// Captures are made byte by byte, in both byte orders, and given in pieces of several sizes.
#include "takt/capture/capture_reader.hpp"

#include <gtest/gtest.h>

#include <string>

#include "capture_bytes.hpp"

namespace takt::capture {
namespace capture_reader_test {

using namespace test;

struct Kept final : PacketSink {
    struct Entry {
        Packet packet;
        Octets data;
    };
    std::vector<Entry> packets;
    void on_packet(const Packet& packet) override {
        packets.push_back({packet, Octets(packet.data.begin(), packet.data.end())});
    }
};

constexpr std::int64_t kTime = 1'700'000'000'123'456'789;

TEST(CaptureReader, ReadsPcapOfBothOrdersAndUnits) {
    for (const bool nanoseconds : {false, true})
        for (const bool big_endian : {false, true})
            for (const std::size_t chunk : {1U, 7U, 4096U}) {
                SCOPED_TRACE(testing::Message() << nanoseconds << big_endian << chunk);
                Kept kept;
                CaptureReader reader(kept);
                const auto file = pcap(LinkType::raw, {{kTime, hex("01 02 03")}, {kTime + 5000, hex("04")}},
                                       nanoseconds, big_endian);
                ASSERT_TRUE(feed(reader, file, chunk));
                ASSERT_EQ(kept.packets.size(), 2u);
                EXPECT_EQ(kept.packets[0].packet.number, 1u);
                EXPECT_EQ(kept.packets[0].packet.link, LinkType::raw);
                EXPECT_EQ(kept.packets[0].packet.time_ns, nanoseconds ? kTime : kTime / 1000 * 1000);
                EXPECT_EQ(kept.packets[0].data, hex("01 02 03"));
                EXPECT_EQ(kept.packets[1].packet.number, 2u);
                EXPECT_EQ(kept.packets[1].packet.time_ns - kept.packets[0].packet.time_ns, 5000);
            }
}

TEST(CaptureReader, ReadsPcapngWithSeveralSectionsAndInterfaces) {
    for (const bool big_endian : {false, true}) {
        Pcapng file(big_endian);
        file.section()
            .interface(LinkType::ethernet)
            .interface(LinkType::user_0, file.resolution(9))
            .block(0x0BAD, Octets(40))
            .packet(1, kTime, hex("0a"))
            .packet(0, kTime / 1000, hex("0b 0c 0d 0e 0f"));
        Pcapng second(!big_endian);
        second.section().interface(LinkType::raw, second.resolution(9)).packet(0, kTime, hex("01"));
        Kept kept;
        CaptureReader reader(kept);
        ASSERT_TRUE(feed(reader, joined({file.bytes, second.bytes}), 5)) << name(reader.error()->fault);
        ASSERT_EQ(kept.packets.size(), 3u);
        EXPECT_EQ(kept.packets[0].packet.link, LinkType::user_0);
        EXPECT_EQ(kept.packets[0].packet.time_ns, kTime);
        EXPECT_EQ(kept.packets[0].packet.interface, 1u);
        EXPECT_EQ(kept.packets[1].packet.time_ns, kTime / 1000 * 1000);
        EXPECT_EQ(kept.packets[1].data, hex("0b 0c 0d 0e 0f"));
        EXPECT_EQ(kept.packets[2].packet.interface, 2u) << "numbered over all sections";
        EXPECT_EQ(kept.packets[2].packet.number, 3u);
    }
}

TEST(CaptureReader, ConvertsResolutionsAndOffsets) {
    const struct {
        std::uint8_t resolution;
        std::uint64_t ticks;
        std::int64_t ns;
    } cases[] = {{0, 7, 7'000'000'000},
                 {3, 1234, 1'234'000'000},
                 {6, 5, 5000},
                 {9, 5, 5},
                 {12, 7999, 7},
                 {0x80 | 10, 1024, 1'000'000'000},
                 {0x80 | 30, 3, 2},
                 {0x80 | 63, ~0ULL, 1'999'999'999},
                 {9, kMostTime, kMostTime}};
    for (const auto& [resolution, ticks, ns] : cases) {
        Pcapng file;
        file.section().interface(LinkType::raw, file.resolution(resolution)).packet(0, ticks, hex("00"));
        Kept kept;
        CaptureReader reader(kept);
        ASSERT_TRUE(feed(reader, file.bytes));
        EXPECT_EQ(kept.packets.at(0).packet.time_ns, ns) << int{resolution};
        EXPECT_TRUE(kept.packets.at(0).packet.timed) << int{resolution};
    }
    Pcapng file;
    file.section().interface(LinkType::raw, file.offset(-2)).packet(0, 3'000'000, hex("00"));
    Kept kept;
    CaptureReader reader(kept);
    ASSERT_TRUE(feed(reader, file.bytes));
    EXPECT_EQ(kept.packets.at(0).packet.time_ns, 1'000'000'000);
}

TEST(CaptureReader, SimplePacketsHaveNoTime) {
    Pcapng file;
    file.section().interface(LinkType::raw, {}, 4).simple(9, hex("01 02 03 04"));
    Kept kept;
    CaptureReader reader(kept);
    ASSERT_TRUE(feed(reader, file.bytes));
    EXPECT_FALSE(kept.packets.at(0).packet.timed);
    EXPECT_EQ(kept.packets.at(0).data, hex("01 02 03 04"));
    EXPECT_EQ(kept.packets.at(0).packet.original_length, 9u);
}

// So the difference of two times never overflows.
TEST(CaptureReader, ATimeOutOfRangeIsNone) {
    const struct {
        std::int64_t offset;
        std::uint64_t ticks;
    } cases[] = {{0, ~0ULL},
                 {0, std::uint64_t{kMostTime} + 1},
                 {-1, 999'999'999},
                 {INT64_MIN, 1},
                 {INT64_MAX, kMostTime},
                 {INT64_MAX, 1'000'000'000}};
    for (const auto& [offset, ticks] : cases) {
        Pcapng file;
        file.section()
            .interface(LinkType::raw, joined({file.offset(offset), file.resolution(9)}))
            .packet(0, ticks, hex("00"));
        Kept kept;
        CaptureReader reader(kept);
        ASSERT_TRUE(feed(reader, file.bytes));
        EXPECT_FALSE(kept.packets.at(0).packet.timed) << offset << ' ' << ticks;
        EXPECT_EQ(kept.packets.at(0).packet.time_ns, 0);
    }
}

TEST(CaptureReader, SkipsLargeBlocksOfOtherKinds) {
    Pcapng file;
    file.section().interface(LinkType::raw).block(0x0BAD, Octets(3 << 20)).packet(0, 1, hex("07"));
    Kept kept;
    CaptureReader reader(kept);
    ASSERT_TRUE(feed(reader, file.bytes, 1 << 16));
    EXPECT_EQ(kept.packets.at(0).data, hex("07"));
}

struct Refused {
    const char* what;
    Octets file;
    CaptureFault fault;
    std::uint64_t offset;
    std::uint64_t value;
    std::uint64_t allowed;
};

std::vector<Refused> refused() {
    const auto good = pcap(LinkType::raw, {{0, hex("01 02 03 04")}});
    auto version = good;
    version[4] = 3;
    auto long_packet = good;
    long_packet[24 + 8 + 2] = 0x10;  // 1 MiB
    auto head = Pcapng().section();
    auto lengths = Pcapng().section().interface(LinkType::raw).bytes;
    lengths[lengths.size() - 4] = 24;
    const Octets cut(good.begin(), good.end() - 1);
    return {
        {"text", hex("68 65 6c 6c 6f"), CaptureFault::not_a_capture, 0, 0x68656C6C, 0},
        {"nothing", {}, CaptureFault::empty, 0, 0, 0},
        {"gzip", hex("1f 8b 08 00"), CaptureFault::compressed, 0, 0x1F8B0800, 0},
        {"zstd", hex("28 b5 2f fd"), CaptureFault::compressed, 0, 0x28B52FFD, 0},
        {"version", version, CaptureFault::version, 0, 3, 2},
        {"long packet", long_packet, CaptureFault::record_length, 24, (1 << 20) + 4, format::kMostPacket},
        {"cut", cut, CaptureFault::incomplete, 24, 19, 20},
        {"no interface", Pcapng(head).packet(0, 1, hex("01")).bytes, CaptureFault::interface, 28, 0, 0},
        {"two lengths", lengths, CaptureFault::length_differs, 28, 24, 20},
        {"short block", Pcapng(head).block(6, hex("00000000")).bytes, CaptureFault::record_too_short, 28, 16,
         32},
        {"resolution", Pcapng(head).interface(LinkType::raw, head.resolution(20)).bytes,
         CaptureFault::resolution, 28, 20, 19},
    };
}

TEST(CaptureReader, FaultsNamePlaceValueAndAllowed) {
    for (const auto& [what, file, fault, offset, value, allowed] : refused()) {
        SCOPED_TRACE(what);
        Kept kept;
        CaptureReader reader(kept);
        EXPECT_FALSE(feed(reader, file, 3));
        ASSERT_TRUE(reader.error());
        EXPECT_EQ(name(reader.error()->fault), name(fault));
        EXPECT_EQ(reader.error()->offset, offset);
        EXPECT_EQ(reader.error()->value, value);
        EXPECT_EQ(reader.error()->allowed, allowed);
    }
}

TEST(CaptureReader, KeepsThePacketsBeforeAFault) {
    auto file = pcap(LinkType::raw, {{0, hex("01")}, {1, hex("02")}});
    file.pop_back();
    Kept kept;
    CaptureReader reader(kept);
    EXPECT_FALSE(feed(reader, file));
    EXPECT_EQ(kept.packets.size(), 1u);
    EXPECT_EQ(reader.error()->packet, 1u);
}

}  // namespace capture_reader_test
}  // namespace takt::capture
