#include <gtest/gtest.h>

#include "listener.hpp"

namespace takt::wire {
namespace framer_tcp_test {

using namespace std::chrono_literals;

constexpr FramerConfig kTcp{.framing = Framing::tcp};
constexpr Instant kNow = Instant{} + 1s;

TEST(TcpFramer, ReportsTheGoldenFramesInOnePiece) {
    Listener server(kTcp);
    server.hex(kNow, "0001 0000 0006 11 03 006B 0003");
    EXPECT_EQ(server.reports(), Reports{"11: 03 00 6B 00 03"});
    EXPECT_EQ(server.framer().frame().transaction, 1);
    EXPECT_EQ(to_hex(server.framer().raw()), "00 01 00 00 00 06 11 03 00 6B 00 03");
    server.hex(kNow, "FFFE 0000 0009 11 03 06 022B 0064 007F 0002 0000 0002 00 07");
    EXPECT_EQ(server.reports(), (Reports{"11: 03 06 02 2B 00 64 00 7F", "00: 07"}));
    EXPECT_EQ(server.framer().frame().transaction, 2);
}

// Hostile-inputs 1..5, 15: within eight bytes, and for good.
TEST(TcpFramer, ABadHeaderEndsTheConnection) {
    struct Row {
        std::string_view bytes;
        std::size_t noticed_after;
    };
    constexpr Row kRows[] = {
        {"0001 0100 0006 11", 3},         // protocol
        {"0001 0001 0006 11", 4},         // protocol
        {"0001 0000 0000 11 03", 6},      // length 0
        {"0001 0000 0001 11 03", 6},      // length 1
        {"0001 0000 00FF 11 03", 6},      // length 255
        {"0001 0000 FFFF 11 03", 6},      // length 65535
        {"4745 5420 2F20 4854 5450", 3},  // GET / HTTP
        {"1603 0102 0001 0001 FC03", 3},  // TLS hello
        {"FFFF FFFF FFFF FFFF FFFF", 3},
    };
    for (const auto& [hex, noticed_after] : kRows) {
        StandaloneFramer framer(kTcp);
        const ByteVector bytes = from_hex(hex);
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            const FramerStep step = framer.push(kNow, Bytes(bytes).subspan(i, 1));
            EXPECT_EQ(step.fault == FrameFault::bad_header, i + 1 >= noticed_after) << hex << " byte " << i;
            EXPECT_FALSE(step.complete);
            EXPECT_EQ(step.consumed, 1U);
        }
        Listener listener(kTcp);
        listener.hex(kNow, hex);
        EXPECT_EQ(listener.reports(), Reports{"!bad_header"});
        listener.framer().reset();
        listener.hex(kNow, "0001 0000 0002 11 07");
        EXPECT_EQ(listener.reports(), Reports{"11: 07"}) << "a new connection";
    }
}

TEST(TcpFramer, TakesTheLongestFrame) {
    ByteVector frame = from_hex("0001 0000 00FE 11");
    frame.resize(kMaxTcpFrame, 0x5A);
    Listener listener(kTcp);
    listener.bytes(kNow, frame);
    ASSERT_EQ(listener.reports().size(), 1U);
    EXPECT_EQ(listener.framer().frame().pdu.size(), kMaxPdu);
}

TEST(TcpFramer, KnowsNoTime) {
    Listener listener(kTcp);
    listener.hex(kNow, "0001 0000 00");
    EXPECT_EQ(listener.framer().next_wakeup(), kNever);
    listener.tick(kNow + 1h);
    listener.hex(kNow + 2h, "02 11 07");
    EXPECT_EQ(listener.reports(), Reports{"11: 07"});
}

// A length that is off by one, while one request waits for its response.
class OffByOne : public testing::Test {
protected:
    static constexpr FramerConfig kTolerant{
        .framing = Framing::tcp, .side = Side::master, .silence = 50ms, .length_tolerance = true};
    static FramerConfig intolerant() {
        auto config = kTolerant;
        config.length_tolerance = false;
        return config;
    }
    struct Master : Listener {
        explicit Master(const FramerConfig& config = kTolerant) : Listener(config) {
            framer().expect_response({.unit = UnitId{1}, .function = 3, .transaction = 5});
        }
    };
};

TEST_F(OffByOne, AnExceptionWhosePromisedByteIsMissingIsAcceptedAfterThePause) {
    Master master;
    master.hex(kNow, "0005 0000 0004 01 83 02");
    EXPECT_EQ(master.reports(), Reports{});
    EXPECT_EQ(master.framer().next_wakeup(), kNow + 50ms);
    master.tick(kNow + 50ms);
    EXPECT_EQ(master.reports(), Reports{"01: 83 02"});
    master.hex(kNow + 1s, "0006 0000 0005 01 03 02 0007");
    EXPECT_EQ(master.reports(), Reports{"01: 03 02 00 07"}) << "the next one is in step";
}

TEST_F(OffByOne, ThePromisedByteOrAHeaderMayFollow) {
    for (const auto* const bytes : {"0005 0000 0006 01 03 02 0007 FF 0005 0000 0003 01 83 02",
                                    "0005 0000 0006 01 03 02 0007 0005 0000 0003 01 83 02",
                                    "0005 0000 0004 01 03 02 0007 0005 0000 0003 01 83 02"}) {
        Master master;
        master.hex(kNow, bytes);
        EXPECT_EQ(master.reports(), (Reports{"01: 03 02 00 07", "01: 83 02"})) << bytes;
    }
}

TEST_F(OffByOne, OnlyOfTheExpectedResponse) {
    for (const auto* const bytes : {"0006 0000 0004 01 83 02",     // another transaction
                                    "0005 0000 0004 02 83 02",     // another unit
                                    "0005 0000 0004 01 84 02",     // another function
                                    "0005 0000 0005 01 83 02"}) {  // off by two
        Master master;
        master.hex(kNow, bytes);
        EXPECT_EQ(master.framer().next_wakeup(), kNever) << bytes;
    }
}

TEST_F(OffByOne, IsSeenWhereItIsNotAccepted) {
    Master master(intolerant());
    master.hex(kNow, "0005 0000 0004 01 83 02");
    EXPECT_TRUE(master.framer().length_is_off());
    EXPECT_EQ(master.framer().next_wakeup(), kNever);
    Master other(intolerant());
    other.hex(kNow, "0005 0000 0007 01 03 04 0001");
    EXPECT_FALSE(other.framer().length_is_off()) << "two bytes are missing";
}

TEST_F(OffByOne, IsSeenInACompleteFrame) {
    for (const auto& [config, bytes] : {std::pair{kTolerant, "0005 0000 0004 01 83 02 00"},
                                        std::pair{kTolerant, "0005 0000 0004 01 03 02 0007"},
                                        std::pair{intolerant(), "0005 0000 0004 01 83 02 00"},
                                        std::pair{intolerant(), "0005 0000 0004 01 03 02 00"}}) {
        Master master(config);
        master.hex(kNow, bytes);
        EXPECT_TRUE(master.framer().length_is_off()) << bytes;
    }
    Master exact;
    exact.hex(kNow, "0005 0000 0005 01 03 02 0007");
    EXPECT_FALSE(exact.framer().length_is_off());
}

}  // namespace framer_tcp_test
}  // namespace takt::wire
