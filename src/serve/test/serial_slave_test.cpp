#include "takt/serve/serial_slave.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "serial_rig.hpp"

namespace takt::serve {
namespace serial_slave_test {

TEST(SerialSlave, AnswersAfterTheSilence) {
    Rig rig(rtu_config());
    rig.receive(kRead);
    const Instant end = rig.now;
    rig.run(kSilence - 1ns);
    EXPECT_EQ(rig.sent, "");
    rig.run(1ns);
    EXPECT_EQ(rig.sent, kReadAnswer);
    EXPECT_EQ(rig.sent_at, end + kSilence);
    EXPECT_EQ(rig.slave.counters().requests, 1u);
    EXPECT_EQ(rig.slave.counters().answers, 1u);
}

TEST(SerialSlave, GoldenFrames) {
    Rig rig(rtu_config());
    rig.first.input[0] = 2;
    rig.first.input[1] = 3;
    EXPECT_EQ(rig.exchange("01 04 00 00 00 02 71 CB"), "01 04 04 00 02 00 03 1A 45");
    rig.units[0].banks.input_registers.values = std::span(rig.first.input).first(15);
    EXPECT_EQ(rig.exchange("01 04 00 00 00 10 F1 C6"), "01 84 02 C2 C1");
    EXPECT_EQ(rig.slave.counters().exceptions, 1u);
}

TEST(SerialSlave, TurnaroundWhereItIsLongerThanTheSilence) {
    struct Row {
        Duration line, answer, expected;
    };
    constexpr Row kRows[] = {
        {0ms, 0ms, kSilence}, {1ms, 0ms, kSilence}, {5ms, 0ms, 5ms}, {5ms, 3ms, 5ms}, {5ms, 8ms, 8ms}};
    for (const auto& [line, answer, expected] : kRows) {
        Scripted scripted;
        scripted.next = Answer::response({0x03, 0x02, 0x00, 0x01}, answer);
        SerialConfig config = rtu_config();
        config.turnaround = line;
        Rig rig(config, &scripted);
        rig.receive(rtu(9, "03 0000 0001"));
        const Instant end = rig.now;
        EXPECT_EQ(scripted.last_time, end);
        rig.run(20ms);
        EXPECT_EQ(rig.sent, rtu(9, "03 02 0001"));
        EXPECT_EQ(rig.sent_at - end, expected);
    }
}

TEST(SerialSlave, OneByOneOrInChunks) {
    for (std::size_t chunk = 1; chunk <= 8; ++chunk) {
        Rig rig(rtu_config());
        rig.receive(kRead, chunk);
        rig.run(10ms);
        EXPECT_EQ(rig.sent, kReadAnswer) << chunk;
    }
}

// hostile-inputs 35, 36, 40, 41: frames that are dropped in silence. The next good frame is served.
TEST(SerialSlave, DropsAndGoesOn) {
    struct Row {
        const char* what;
        std::string input;
        std::string answer;
        wire::FrameFault fault;
    };
    std::string megabyte;
    for (int i = 0; i < 20'000; ++i) megabyte += "A5 ";
    const Row kRows[] = {
        {"bad CRC", "01 03 00 10 00 02 00 00", "", wire::FrameFault::checksum},
        {"one byte", "01", "", wire::FrameFault::too_short},
        {"three bytes", "01 03 00", "", wire::FrameFault::too_short},
        {"over 256 bytes", megabyte, "", wire::FrameFault::too_long},
        {"good CRC, wrong length", rtu(1, "03 0010 0002 00"), rtu(1, "83 03"), wire::FrameFault::none},
        {"good CRC, function alone", rtu(1, "03"), rtu(1, "83 03"), wire::FrameFault::none},
        {"function 0", rtu(1, "00"), rtu(1, "80 01"), wire::FrameFault::none},
        {"unknown function", rtu(1, "63 01 02"), rtu(1, "E3 01"), wire::FrameFault::none},
    };
    for (const auto& [what, input, answer, fault] : kRows) {
        Rig rig(rtu_config());
        EXPECT_EQ(rig.exchange(input), answer) << what;
        rig.run(SerialSlave::kDeliveryPause);  // more of the frame could follow
        EXPECT_TRUE(fault == wire::FrameFault::none || rig.slave.counters().of(fault) >= 1) << what;
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer) << "after " << what;
    }
}

// A common library loses all 60.
TEST(SerialSlave, AnswersTheNextGoodRequestAfterASilence) {
    struct Row {
        const char* what;
        std::string before;
    };
    const Row kRows[] = {
        {"a stray byte", "FF"},
        {"a stray own address", "01"},
        {"half a frame", kRead.substr(0, 12)},
        {"half a write", rtu(1, "10 0010 0002 04 0001 0002").substr(0, 21)},
        {"a neighbour that is dead", rtu(7, "03 0000 0004")},
        {"a neighbour that stops in mid-answer",
         rtu(7, "03 0000 0004") + rtu(7, "03 08 0001 0002").substr(0, 12)},
        {"a neighbour's custom function", rtu(7, "41 0102")},
    };
    for (const auto& [what, before] : kRows) {
        Rig rig(rtu_config());
        int answered = 0;
        for (int round = 0; round < 60; ++round) {
            rig.receive(before);
            rig.run(round % 2 == 0 ? kSilence + 1us : 30ms);
            answered += rig.exchange(kRead) == kReadAnswer;
        }
        EXPECT_EQ(answered, 60) << what;
    }
}

// 39: glued frames, noise right before a frame.
TEST(SerialSlave, SurplusIsDroppedUpToTheNextSilence) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(kRead + rtu(1, "06 0000 1234")), kReadAnswer);
    EXPECT_EQ(rig.first.holding[0], 0) << "the second of two glued frames is not executed";
    EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::surplus), 1u);
    EXPECT_EQ(rig.exchange("FF " + kRead).size() % kReadAnswer.size(), 0u)
        << "may be lost, must not be garbled";
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
}

TEST(SerialSlave, TheSecondOfTwoFramesInOnePieceIsSurplus) {
    Rig rig(rtu_config());
    rig.slave.on_bytes(rig.now, bytes(kRead + rtu(1, "06 0000 1234")));
    rig.run(30ms);
    EXPECT_EQ(rig.sent, kReadAnswer);
    EXPECT_EQ(rig.first.holding[0], 0);
    EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::surplus), 1u);
}

// 38
TEST(SerialSlave, IgnoresOtherUnitsWhetherTheyAnswerOrNot) {
    Rig rig(rtu_config());
    for (int i = 0; i < 50; ++i) {
        EXPECT_EQ(rig.exchange(rtu(7, "03 0000 0004")), "");
        if (i % 2 == 0) {
            EXPECT_EQ(rig.exchange(rtu(7, "03 08 0001 0002 0003 0004")), "");
        }
        EXPECT_EQ(rig.exchange(rtu(255, "03 0000 0001")), "") << "255 is no unit of a serial line";
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    }
    EXPECT_EQ(rig.slave.counters().other_units, 125u);
    EXPECT_EQ(rig.slave.counters().requests, 50u);
}

TEST(SerialSlave, ReceivesItsRequestRightBehindAnotherUnitsAnswer) {
    Rig rig(rtu_config());
    const std::string others = rtu(7, "03 0000 0002") + rtu(7, "03 04 0001 0002");
    EXPECT_EQ(rig.exchange(others + kRead), kReadAnswer) << "an adapter may hand them over in one piece";
}

// 42
TEST(SerialSlave, Broadcasts) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(rtu(0, "06 0003 ABCD")), "");
    EXPECT_EQ(rig.first.holding[3], 0xABCD);
    EXPECT_EQ(rig.second.holding[3], 0xABCD);
    EXPECT_EQ(rig.exchange(rtu(0, "03 0000 0001")), "");
    EXPECT_EQ(rig.exchange(rtu(0, "63")), "");
    EXPECT_EQ(rig.slave.counters().broadcasts, 3u);
    EXPECT_EQ(rig.slave.counters().unanswered, 0u);
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
}

TEST(SerialSlave, ANewRequestTakesTheWaitingOnesPlaceOrIsDropped) {
    for (const bool finish_first : {false, true}) {
        SerialConfig config = rtu_config();
        config.turnaround = 50ms;
        config.finish_first = finish_first;
        Rig rig(config);
        rig.receive(kRead);
        rig.run(20ms);
        rig.receive(rtu(1, "03 0001 0001"));
        rig.run(100ms);
        EXPECT_EQ(rig.sent, finish_first ? kReadAnswer : rtu(1, "03 02 0001"));
        EXPECT_EQ(rig.slave.counters().unanswered, 1u);
    }
}

TEST(SerialSlave, AnswersOfSeveralUnitsKeepTheSilenceBetweenThem) {
    SerialConfig config = rtu_config();
    config.turnaround = 30ms;
    Rig rig(config);
    rig.receive(rtu(1, "03 0001 0001"));
    rig.run(2ms);
    rig.receive(rtu(2, "03 0002 0001"));
    rig.run(100ms);
    EXPECT_EQ(rig.sent, rtu(1, "03 02 0001") + " | " + rtu(2, "03 02 0002"));
}

TEST(SerialSlave, AnswersThatAreDueTogetherKeepTheSilence) {
    Scripted scripted;
    Rig rig(rtu_config(), &scripted);
    for (const std::uint8_t unit : {std::uint8_t{9}, std::uint8_t{10}}) {
        scripted.next = Answer::pending(unit);
        rig.exchange(rtu(unit, "03 0000 0001"));
    }
    for (const Token token : {9u, 10u}) EXPECT_TRUE(rig.slave.complete(rig.now, token, bytes("03 02 0042")));
    rig.collect();
    EXPECT_EQ(rig.sent, rtu(9, "03 02 0042"));
    const Instant first = rig.sent_at;
    rig.run(20ms);
    EXPECT_EQ(rig.sent_at - first, wire::transmission_time(kFast, 7) + kSilence);
}

TEST(SerialSlave, PendingAnswersComeLaterOrNever) {
    Scripted scripted;
    Rig rig(rtu_config(), &scripted);
    const std::string request = rtu(9, "03 0000 0001");
    const auto answer = bytes("03 02 0042");

    scripted.next = Answer::pending(5);
    EXPECT_EQ(rig.exchange(request), "");
    EXPECT_FALSE(rig.slave.complete(rig.now, 6, answer));
    EXPECT_TRUE(rig.slave.complete(rig.now, 5, answer));
    EXPECT_FALSE(rig.slave.complete(rig.now, 5, answer));
    rig.collect();
    EXPECT_EQ(rig.sent, rtu(9, "03 02 0042"));

    rig.sent.clear();
    rig.run(10ms);
    scripted.next = Answer::pending(7);
    rig.receive(request);
    EXPECT_TRUE(rig.slave.complete(rig.now, 7, answer)) << "at once: still not before the silence";
    rig.collect();
    EXPECT_EQ(rig.sent, "");
    rig.run(kSilence);
    EXPECT_EQ(rig.sent, rtu(9, "03 02 0042"));

    scripted.next = Answer::pending(8);
    EXPECT_EQ(rig.exchange(request), "");
    scripted.next = {};
    EXPECT_EQ(rig.exchange(request), "");
    EXPECT_FALSE(rig.slave.complete(rig.now, 8, answer)) << "overtaken";
    EXPECT_EQ(rig.slave.counters().unanswered, 2u);
}

TEST(SerialSlave, ALostLinkForgetsEverything) {
    Rig rig(rtu_config());
    rig.receive(kRead);
    rig.slave.on_link(rig.now, false);
    rig.run(50ms);
    rig.receive(kRead);
    rig.run(50ms);
    EXPECT_EQ(rig.sent, "");
    rig.receive(kRead.substr(0, 9));
    rig.slave.on_link(rig.now, true);
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    EXPECT_EQ(rig.slave.counters().unanswered, 1u);
}

TEST(SerialSlave, ReportsItsTraffic) {
    Log log;
    Rig rig(rtu_config(), nullptr, &log);
    rig.exchange(kRead);
    rig.exchange(rtu(7, "03 0000 0001"));
    rig.exchange("01 03 00 10 00 02 00 00", 50ms);
    EXPECT_EQ(log.lines, (std::vector<std::string>{"received 03 00 10 00 02", "sent 03 04 00 10 00 11",
                                                   "received 03 00 00 00 01", "checksum"}));
}

// After any input the output is good frames only, and after a silence a good request is served.
RC_GTEST_PROP(SerialSlave, NoiseNeverMakesItDeaf, ()) {
    Rig rig(rtu_config());
    const auto noise = *rc::gen::container<std::vector<std::vector<std::uint8_t>>>(
        rc::gen::container<std::vector<std::uint8_t>>(
            rc::gen::weightedOneOf<std::uint8_t>({{1, rc::gen::element<std::uint8_t>(0, 1, 3, 6, 16, 0x83)},
                                                  {1, rc::gen::arbitrary<std::uint8_t>()}})));
    for (const auto& burst : noise) {
        rig.receive(hex(burst), *rc::gen::inRange<std::size_t>(1, 20));
        rig.run(*rc::gen::element<Duration>(100us, 1ms, 2ms, 10ms));
    }
    rig.run(20ms);
    RC_ASSERT(rig.exchange(kRead) == kReadAnswer);
}

}  // namespace serial_slave_test
}  // namespace takt::serve
