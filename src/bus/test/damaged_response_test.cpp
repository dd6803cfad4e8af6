// Damaged responses and noise: what ends a transaction, and what is waited for.
#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace damaged_response_test {

using namespace test;

TEST(DamagedResponse, GarbageAloneIsABadChecksumAtTheDeadline) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(20ms));
    rig.receive(at(20ms), "01 03 02");
    rig.run_until(at(200ms));
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::bad_checksum);
    EXPECT_EQ(rig.engine.counters().checksums, 1U);
}

// The pause that ends a received frame, 30 ms, is not over at the deadline.
TEST(DamagedResponse, ACompleteResponseWithABadChecksumIsNoTimeout) {
    for (const auto& [received, status] : {std::pair("01 03 02 00 07 F9 87", Status::bad_checksum),
                                           std::pair("01 03 02 00 07 F9", Status::bad_checksum),
                                           std::pair("01 07 02 00 07 F9", Status::timeout)}) {
        Rig rig;
        rig.now = at(10ms);
        rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01", 10ms));
        rig.run_until(at(20ms));
        rig.receive(at(20ms), received);
        rig.run_until(at(45ms));
        ASSERT_EQ(rig.outcomes.size(), 1U) << received;
        EXPECT_EQ(rig.last().status, status) << received;
    }
}

// The response begins as expected and has its length: nothing more can come. It needs no pause after it.
TEST(DamagedResponse, AResponseThatCameDamagedIsNotWaitedFor) {
    LineConfig terminal = kLine;
    terminal.echo = Echo::untimed;
    LineConfig stream = kLine;
    stream.format.baud = 0;
    stream.echo = Echo::absent;
    for (const auto& config : {kLine, terminal, stream}) {
        Rig rig(config);
        rig.now = at(10ms);
        rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", 300ms));
        rig.run_until(at(30ms));
        rig.receive(at(30ms), "01 03 04 00 07 00 08 FF FF");
        ASSERT_EQ(rig.outcomes.size(), 1U);
        EXPECT_EQ(rig.last().status, Status::bad_checksum);
        EXPECT_EQ(rig.last().ended_at, at(30ms));
        EXPECT_LE(rig.engine.earliest_start(UnitId{1}, {3, 6}), at(30ms + kT35));
    }
}

// The unit is wrong too: as many bytes as the response has, and the pause after them, show that it came.
TEST(DamagedResponse, OnAPseudoTerminalADamagedResponseComesBeforeTheRequestCouldHaveLeft) {
    LineConfig terminal = kLine;
    terminal.echo = Echo::untimed;
    Rig rig(terminal);
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", 300ms));
    rig.run_until(at(11ms));
    rig.receive(at(11ms), "81 03 04 00 07 00 08 FF FF");  // the request ends at 14 ms
    rig.run_until(at(41ms));
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::bad_checksum);
    EXPECT_LE(rig.engine.earliest_start(UnitId{1}, {3, 6}), at(41ms));
}

// A write is repeated by its response. On a line with echoes the damaged frame may be the echo.
TEST(DamagedResponse, ADamagedEchoIsNoDamagedResponse) {
    LineConfig terminal = kLine;
    terminal.echo = Echo::untimed;
    for (const bool echoes : {false, true}) {
        Rig rig(terminal);
        rig.now = at(10ms);
        rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
        rig.run_until(at(20ms));
        if (echoes) rig.receive(at(20ms), rtu(1, "03 00 00 00 01"));
        rig.receive(at(20ms), rtu(1, "03 02 00 05"));
        ASSERT_EQ(rig.outcomes.size(), 1U);

        rig.submit(at(30ms), transaction(2, 1, "06 00 01 00 03"));
        rig.now = at(30ms);
        rig.run_until(at(31ms));
        rig.receive(at(31ms), "01 06 00 01 00 03 FF FF");
        ASSERT_EQ(rig.outcomes.size(), echoes ? 1U : 2U);
        if (!echoes) {
            EXPECT_EQ(rig.last().status, Status::bad_checksum);
            continue;
        }
        rig.receive(at(50ms), rtu(1, "06 00 01 00 03"));
        ASSERT_EQ(rig.outcomes.size(), 1U);  // on this line the first repetition is the echo
        rig.receive(at(60ms), rtu(1, "06 00 01 00 03"));
        ASSERT_EQ(rig.outcomes.size(), 2U);
        EXPECT_EQ(rig.last().status, Status::ok);
    }
}

TEST(DamagedResponse, FindsTheResponseBehindNoise) {
    struct Case {
        const char* what;
        const char* request;
        const char* noise;
        const char* response;
        const char* after;
    };
    constexpr Case kCases[] = {
        {"a zero", "03 00 00 00 01", "00", "03 02 00 07", ""},
        {"ones", "03 00 00 00 01", "FF", "03 02 00 07", "FF"},
        {"a zero after it", "03 00 00 00 01", "", "03 02 00 07", "00"},
        {"the beginning of a longer frame", "03 00 00 00 01", "02 03 20", "03 02 00 07", ""},
        {"the own unit", "03 00 00 00 01", "01", "03 02 00 07", ""},
        {"the own beginning", "03 00 00 00 01", "01 03 02", "03 02 00 07", ""},
        {"an exception", "03 00 00 00 01", "00 FF", "83 02", "00"},
        {"coils", "01 00 00 00 09", "FF", "01 02 AA 01", ""},
        {"a write", "06 00 01 00 03", "00", "06 00 01 00 03", "FF"},
        {"a response of any length", "11", "00", "11 03 01 FF 41", ""},
        {"many bytes", "03 00 00 00 01", "FF 00 FF 00 FF 00 FF 00 FF 00 FF 00", "03 02 00 07", "00 FF 00"},
    };
    LineConfig terminal = kLine;
    terminal.echo = Echo::untimed;
    for (const auto& config : {kLine, terminal})
        for (const auto& c : kCases) {
            Rig rig(config);
            rig.now = at(10ms);
            rig.submit(rig.now, transaction(1, 1, c.request, 200ms));
            rig.run_until(at(40ms));
            const auto noise = hex(c.noise);
            auto received = rtu(1, c.response);
            const auto after = hex(c.after);
            received.insert(received.end(), after.begin(), after.end());
            if (!noise.empty()) rig.receive(at(40ms), noise);
            rig.run_until(at(45ms));
            rig.receive(at(45ms), received);
            rig.run_until(at(80ms));
            ASSERT_EQ(rig.outcomes.size(), 1U) << c.what;
            EXPECT_TRUE(rig.last().status == Status::ok || rig.last().status == Status::exception) << c.what;
            EXPECT_EQ(rig.last().ended_at, at(45ms)) << c.what;
            EXPECT_EQ(rig.last().noise, noise.size()) << c.what;
            EXPECT_EQ(rig.engine.counters().noise_bytes, noise.size()) << c.what;
            EXPECT_EQ(rig.engine.counters().noisy_answers, noise.empty() ? 0U : 1U) << c.what;
            EXPECT_EQ(rig.engine.counters().unsolicited_bytes, after.size()) << c.what;
            // The noise after it does not damage the next response.
            rig.submit(rig.now, transaction(2, 1, "03 00 00 00 01", 200ms));
            rig.run_until(at(100ms));
            rig.receive(at(100ms), rtu(1, "03 02 00 08"));
            ASSERT_EQ(rig.outcomes.size(), 2U) << c.what;
            EXPECT_EQ(rig.last().noise, 0U) << c.what;
        }
}

// The first byte is that of a longer frame. Its pause would end after the deadline.
TEST(DamagedResponse, TheDeadlineEndsNoResponseBehindNoise) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01", 10ms));
    rig.run_until(at(20ms));
    auto received = rtu(1, "03 02 00 07");
    received.insert(received.begin(), {0x10, 0x03, 0x10});
    rig.receive(at(20ms), received);
    EXPECT_TRUE(rig.outcomes.empty());
    rig.run_until(at(40ms));
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::ok);
    EXPECT_EQ(rig.last().ended_at, at(20ms));
}

// The data of another unit's response may look like the expected one.
TEST(DamagedResponse, NoResponseIsFoundInsideAGoodFrame) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(20ms));
    rig.receive(at(20ms), rtu(2, "03 0A 00 00 01 03 02 00 07 F9 86 00"));
    rig.run_until(at(60ms));
    EXPECT_TRUE(rig.outcomes.empty());
    EXPECT_EQ(rig.engine.counters().foreign_frames, 1U);
}

TEST(DamagedResponse, ADriverThatAddsABytePreventsNoEcho) {
    LineConfig terminal = kLine;
    terminal.echo = Echo::untimed;
    Rig rig(terminal);
    for (unsigned i = 0; i < 5; ++i) {
        const Instant t = at(100ms * (i + 1));
        rig.now = t;
        rig.submit(t, transaction(1, 1, "03 00 00 00 01"));
        rig.run_until(t + 10ms);
        auto received = rtu(1, "03 00 00 00 01");
        received.insert(received.begin(), 0x00);
        const auto answer = rtu(1, "03 02 00 05");
        received.insert(received.end(), answer.begin(), answer.end());
        rig.receive(t + 10ms, received);
        ASSERT_EQ(rig.outcomes.size(), i + 1U);
        EXPECT_EQ(rig.last().status, Status::ok);
        EXPECT_EQ(rig.last().noise, 1U);
    }
    rig.submit(at(600ms), transaction(2, 1, "06 00 01 00 03"));
    rig.now = at(600ms);
    rig.run_until(at(610ms));
    auto echo = rtu(1, "06 00 01 00 03");
    echo.insert(echo.begin(), 0x00);
    rig.receive(at(610ms), echo);
    EXPECT_EQ(rig.outcomes.size(), 5U);  // the echo alone does not confirm a write
    rig.receive(at(620ms), rtu(1, "06 00 01 00 03"));
    ASSERT_EQ(rig.outcomes.size(), 6U);
    EXPECT_EQ(rig.last().status, Status::ok);
}

TEST(DamagedResponse, ADamagedAsciiResponseIsNotWaitedFor) {
    LineConfig ascii = kLine;
    ascii.framing = wire::Framing::ascii;
    for (const char damage : {'0', 'x', ' '}) {
        Rig rig(ascii);
        rig.now = at(10ms);
        rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01", 300ms));
        rig.run_until(at(50ms));
        const auto frame = wire::encode_frame(wire::Framing::ascii, UnitId{1}, 0, hex("03 02 00 F7"));
        std::vector<std::uint8_t> received{0x00, 0xFF};  // noise before ':' is ignored
        received.insert(received.end(), frame.begin(), frame.end());
        received[2 + 9] = static_cast<std::uint8_t>(damage);
        rig.receive(at(50ms), received);
        ASSERT_EQ(rig.outcomes.size(), 1U) << damage;
        EXPECT_EQ(rig.last().status, Status::bad_checksum) << damage;
        EXPECT_EQ(rig.last().ended_at, at(50ms)) << damage;
    }
}

// Neither the unit nor the function is that of the response: it is noise, and the response may follow. Noise
// that ended the transaction let the response pass for the one to the next request.
TEST(DamagedResponse, NoiseOfItsLengthIsNoDamagedResponse) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", 300ms));
    rig.run_until(at(30ms));
    rig.receive(at(30ms), "EE 55 04 00 07 00 08 FF FF");
    rig.run_until(at(100ms));
    EXPECT_TRUE(rig.outcomes.empty());
    rig.receive(at(100ms), rtu(1, "03 04 00 01 00 02"));
    ASSERT_EQ(rig.outcomes.size(), 1U);
    ASSERT_EQ(rig.last().status, Status::ok);
    EXPECT_EQ(rig.last().response.registers()[0], 1U);
}

}  // namespace damaged_response_test
}  // namespace takt::bus
