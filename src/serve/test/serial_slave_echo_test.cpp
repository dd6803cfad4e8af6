// A line that gives back what is sent, and one that only seems to.
#include "serial_rig.hpp"

namespace takt::serve {
namespace serial_slave_echo_test {

// 43
TEST(SerialSlave, OwnEchoIsDiscarded) {
    for (const Duration latency : {Duration{}, Duration{12ms}}) {
        Log log;
        Rig rig(rtu_config(), nullptr, &log);
        const std::string write = rtu(1, "06 0000 0007");
        for (int i = 0; i < 6; ++i) {
            const bool reads = i < 2;  // from these it is known that the line echoes, however late
            rig.sent.clear();
            rig.receive(reads ? kRead : write);
            rig.run(kSilence);
            ASSERT_EQ(rig.sent, reads ? kReadAnswer : write);
            rig.run(latency);
            rig.receive(rig.sent, static_cast<std::size_t>(1 + 3 * (i % 3)));
            rig.run(kSilence);
        }
        rig.run(20ms);
        EXPECT_EQ(rig.slave.counters().echoes, 6u);
        EXPECT_EQ(rig.slave.counters().requests, 6u);
        EXPECT_EQ(log.lines.size(), 12u) << "an echo is no traffic";
    }
}

TEST(SerialSlave, AnEchoInTimeIsKnownFromTheFirstAnswerOn) {
    Rig rig(rtu_config());
    const std::string write = rtu(1, "06 0000 0007");
    EXPECT_EQ(rig.exchange(write, kSilence), write);
    rig.receive(rig.sent);
    rig.run(20ms);
    EXPECT_EQ(rig.sent, write);
    EXPECT_EQ(rig.slave.counters().echoes, 1u);
}

// A master need not keep the silence for this: some send the next request as soon as they have the answer.
TEST(SerialSlave, ARepeatedRequestThatLooksLikeTheEchoIsServed) {
    for (const Duration gap : {Duration{}, Duration{100us}, kSilence, Duration{10ms}}) {
        Rig rig(rtu_config());
        const std::string write = rtu(1, "06 0000 0007");
        for (int i = 0; i < 5; ++i) {
            EXPECT_EQ(rig.exchange(i == 2 ? kRead : write, kSilence), i == 2 ? kReadAnswer : write)
                << gap.count();
            rig.run(wire::transmission_time(kFast, i == 2 ? 9 : 8) + gap);
        }
        EXPECT_EQ(rig.slave.counters().requests, 5u);
        EXPECT_EQ(rig.slave.counters().echoes, 0u);
    }
}

TEST(SerialSlave, OnAPseudoTerminalARepeatedWriteIsServedHoweverSoon) {
    for (const bool untimed : {true, false}) {
        SerialConfig config = rtu_config();
        config.untimed = untimed;
        Rig rig(config);
        const auto write = bytes(rtu(1, "06 0000 0007"));
        for (int i = 0; i < 3; ++i) {
            rig.slave.on_bytes(rig.now, write);
            rig.run(kSilence);
            rig.run(1us);
        }
        rig.run(10ms);
        EXPECT_EQ(rig.slave.counters().requests, untimed ? 3u : 2u);
        EXPECT_EQ(rig.slave.counters().echoes, untimed ? 0u : 1u);
    }
}

TEST(SerialSlave, ALineThatNoLongerEchoesIsBelieved) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(kRead, kSilence), kReadAnswer);
    rig.receive(kReadAnswer);
    EXPECT_EQ(rig.slave.counters().echoes, 1u);
    rig.run(30ms);
    EXPECT_EQ(rig.exchange(kRead, 3ms), kReadAnswer);
    const std::string write = rtu(1, "06 0000 0007");
    for (int i = 0; i < 3; ++i) EXPECT_EQ(rig.exchange(write, 5ms), write) << i;
    EXPECT_EQ(rig.slave.counters().echoes, 1u);
}

TEST(SerialSlave, ARequestThatBeginsLikeTheAnswerBeforeIsServed) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(kRead, kSilence), kReadAnswer);
    rig.run(wire::transmission_time(kFast, 9) + kSilence - 1us);
    rig.sent.clear();
    rig.receive(rtu(1, "03 0410 0001"));  // shares 01 03 04 with the answer
    rig.run(20ms);
    EXPECT_EQ(rig.sent, rtu(1, "83 02"));
}

// An adapter delivers a frame in pieces.
TEST(SerialSlave, ARequestInPiecesAfterAnAnswerIsServed) {
    const auto request = bytes(rtu(1, "03 0001 0001"));
    for (const std::size_t first : {1U, 2U})
        for (const Duration pause : {2ms, 5ms, 25ms})
            for (const Duration wait : {3ms, 5ms, 40ms}) {
                Rig rig(rtu_config());
                EXPECT_EQ(rig.exchange(kRead, kSilence), kReadAnswer);
                rig.run(wait);
                rig.sent.clear();
                rig.slave.on_bytes(rig.now, Bytes(request).first(first));
                rig.run(pause);
                rig.slave.on_bytes(rig.now, Bytes(request).subspan(first));
                rig.run(20ms);
                EXPECT_FALSE(rig.sent.empty()) << first << ' ' << pause.count() << ' ' << wait.count();
                EXPECT_EQ(rig.slave.counters().requests, 2U);
            }
}

TEST(SerialSlave, AnEchoInPiecesIsDiscarded) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(kRead, kSilence), kReadAnswer);
    const auto echo = bytes(kReadAnswer);
    rig.slave.on_bytes(rig.now, Bytes(echo).first(4));
    rig.run(5ms);
    rig.slave.on_bytes(rig.now, Bytes(echo).subspan(4));
    rig.run(20ms);
    EXPECT_EQ(rig.slave.counters().echoes, 1U);
    EXPECT_EQ(rig.slave.counters().requests, 1U);
}

TEST(SerialSlave, AnEchoBehindNoiseIsDiscarded) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(kRead, kSilence), kReadAnswer);
    rig.receive("01");
    rig.run(3ms);
    rig.receive(kReadAnswer);
    rig.run(20ms);
    EXPECT_EQ(rig.slave.counters().echoes, 1U);
    EXPECT_EQ(rig.slave.counters().requests, 1U);
}

TEST(SerialSlave, NoiseThatBeginsLikeTheAnswerCostsNothing) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(kRead, kSilence), kReadAnswer);
    rig.receive("01");
    rig.run(5ms);
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
}

}  // namespace serial_slave_echo_test
}  // namespace takt::serve
