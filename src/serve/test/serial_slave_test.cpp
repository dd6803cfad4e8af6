#include "takt/serve/serial_slave.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>

#include "support.hpp"

namespace takt::serve {
namespace {

using namespace std::chrono_literals;

constexpr wire::CharacterFormat kFast{115200, 8, wire::Parity::none, 1};
constexpr Duration kSilence = 1750us;

/// The frames as "received 03 ..." or "sent ..."; faults as their names.
class Log final : public wire::TrafficObserver {
public:
    void on_frame(Instant, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) override {
        EXPECT_EQ(raw.size(), pdu.size() + 3);
        EXPECT_EQ(raw[0], unit.value);
        lines.push_back((direction == wire::Direction::sent ? "sent " : "received ") + hex(pdu));
    }
    void on_fault(Instant, wire::FrameFault fault) override { lines.emplace_back(wire::name(fault)); }
    std::vector<std::string> lines;
};

/// A responder that says what the test wants, for one unit.
class Scripted final : public Responder {
public:
    [[nodiscard]] bool serves(UnitId unit) const override { return unit == UnitId{9} || unit == UnitId{10}; }
    [[nodiscard]] Answer handle(const Context& context, Bytes) override {
        last_time = context.time;
        ++calls;
        return next;
    }
    Answer next;
    Instant last_time;
    int calls = 0;
};

/// One slave engine on a line whose time the test moves. Units 1 and 2 are served unless another responder is
/// given.
class Rig {
public:
    explicit Rig(SerialConfig config = {}, Responder* responder = nullptr,
                 wire::TrafficObserver* observer = nullptr)
        : units{Unit{UnitId{1}, first.banks(), nullptr}, Unit{UnitId{2}, second.banks(), nullptr}},
          server(units),
          format(config.format),
          slave(config, responder ? *responder : server, observer) {
        slave.on_link(now, true);
        run(10ms);
    }

    /// The bytes come over the line from now on, `chunk` at a time.
    void hear(const std::string& text, std::size_t chunk = 1) {
        const auto data = bytes(text);
        const Instant start = now;
        for (std::size_t done = 0; done < data.size();) {
            const std::size_t count = std::min(chunk, data.size() - done);
            run_until(start + wire::transmission_time(format, done + count));
            slave.on_bytes(now, Bytes(data).subspan(done, count));
            done += count;
            collect();
        }
    }
    void run(Duration length) { run_until(now + length); }

    /// Hears, waits, and gives what was sent meanwhile.
    std::string exchange(const std::string& text, Duration wait = 20ms) {
        sent.clear();
        hear(text);
        run(wait);
        return sent;
    }

    void run_until(Instant end) {
        while (slave.next_wakeup() <= end) {
            now = std::max(now, slave.next_wakeup());
            slave.on_tick(now);
            collect();
        }
        now = end;
    }
    void collect() {
        for (Bytes out = slave.transmit(now); !out.empty(); out = slave.transmit(now)) {
            if (!sent.empty()) sent += " | ";
            sent += hex(out);
            sent_at = now;
        }
    }

    Storage first, second;
    std::array<Unit, 2> units;
    Server server;
    wire::CharacterFormat format;
    SerialSlave slave;
    Instant now{};
    std::string sent;
    Instant sent_at{};
};

SerialConfig rtu_config() {
    return {.format = kFast};
}
SerialConfig ascii_config() {
    return {.framing = wire::Framing::ascii, .format = {9600, 7, wire::Parity::even, 1}};
}

const std::string kRead = rtu(1, "03 0010 0002");
const std::string kReadAnswer = rtu(1, "03 04 0010 0011");

TEST(SerialSlave, AnswersAfterTheSilence) {
    Rig rig(rtu_config());
    rig.hear(kRead);
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
        rig.hear(rtu(9, "03 0000 0001"));
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
        rig.hear(kRead, chunk);
        rig.run(10ms);
        EXPECT_EQ(rig.sent, kReadAnswer) << chunk;
    }
}

// hostile-inputs 35, 36, 40, 41: what is dropped in silence, and that the next good frame is served.
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
        EXPECT_TRUE(fault == wire::FrameFault::none || rig.slave.counters().of(fault) >= 1) << what;
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer) << "after " << what;
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

TEST(SerialSlave, WaitsForSilenceBehindSurplusBytes) {
    Rig rig(rtu_config());
    rig.hear(kRead);
    rig.run(1ms);
    rig.hear("55");
    const Instant last = rig.now;
    rig.run(20ms);
    EXPECT_EQ(rig.sent, kReadAnswer);
    EXPECT_EQ(rig.sent_at, last + kSilence);
}

TEST(SerialSlave, APseudoTerminalDeliversAtOnceAndIsNotTakenForSurplus) {
    // At 1200 bit/s the answer takes 75 ms of computed time; the master has it at once and asks again after
    // its t3.5.
    Rig rig({.format = {1200, 8, wire::Parity::none, 1}});
    const auto request = bytes(kRead);
    for (int round = 0; round < 3; ++round) {
        rig.sent.clear();
        rig.slave.on_bytes(rig.now, request);
        while (rig.sent.empty() && rig.slave.next_wakeup() != kNever) rig.run_until(rig.slave.next_wakeup());
        EXPECT_EQ(rig.sent, kReadAnswer) << round;
        rig.run(30ms);
    }
    EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::surplus), 0u);
}

TEST(SerialSlave, AUartDeliversAFrameInLumps) {
    // 14 characters at a time: the second lump is told 14 character times after the first, far more than
    // t3.5.
    Rig rig(rtu_config());
    const std::string write = rtu(1, "10 0010 0004 08 0001 0002 0003 0004");
    rig.sent.clear();
    rig.hear(write, 14);
    rig.run(20ms);
    EXPECT_EQ(rig.sent, rtu(1, "10 0010 0004"));
}

TEST(SerialSlave, AnAnswerThatNoiseHasDelayedTooLongIsNotSent) {
    for (const Duration noise : {400ms, 600ms}) {
        Rig rig(rtu_config());
        rig.hear(kRead);
        for (const Instant end = rig.now + noise; rig.now < end; rig.run(1ms)) rig.hear("55");
        rig.run(20ms);
        EXPECT_EQ(rig.sent, noise < SerialSlave::kLatest ? kReadAnswer : "");
        EXPECT_EQ(rig.slave.counters().unanswered, noise < SerialSlave::kLatest ? 0u : 1u);
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    }
}

// 37
TEST(SerialSlave, StrictModeRefusesPauses) {
    SerialConfig config = rtu_config();
    for (const bool strict : {false, true}) {
        config.strict = strict;
        Rig rig(config);
        const std::string request = kRead;
        rig.hear(request.substr(0, 12));
        rig.run(1000us);
        rig.hear(request.substr(12));
        rig.run(20ms);
        EXPECT_EQ(rig.sent, strict ? "" : kReadAnswer);
        EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::pause), strict ? 1u : 0u);
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    }
}

TEST(SerialSlave, ALateAdapterCutsFramesAndIsNotTooSlowForTheNext) {
    SerialConfig config = rtu_config();
    config.frame_silence = 20ms;
    Rig rig(config);
    for (int i = 0; i < 5; ++i) {
        rig.sent.clear();
        rig.hear(kRead.substr(0, 9));
        rig.run(16ms);
        rig.hear(kRead.substr(9));
        rig.run(kSilence);
        EXPECT_EQ(rig.sent, kReadAnswer) << i;
        rig.run(wire::transmission_time(kFast, 9) + kSilence);
    }
}

// 38
TEST(SerialSlave, IgnoresOtherUnitsWhetherTheyAnswerOrNot) {
    Rig rig(rtu_config());
    for (int i = 0; i < 50; ++i) {
        EXPECT_EQ(rig.exchange(rtu(7, "03 0000 0004")), "");
        if (i % 2 == 0) {
            EXPECT_EQ(rig.exchange(rtu(7, "03 08 0001 0002 0003 0004")), "");
        }
        EXPECT_EQ(rig.exchange(rtu(255, "03 0000 0001")), "") << "255 is nobody on a serial line";
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    }
    EXPECT_EQ(rig.slave.counters().other_units, 125u);
    EXPECT_EQ(rig.slave.counters().requests, 50u);
}

TEST(SerialSlave, HearsItsRequestRightBehindAnotherUnitsAnswer) {
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

// 43
TEST(SerialSlave, OwnEchoIsDiscarded) {
    for (const Duration latency : {Duration{}, Duration{12ms}}) {
        Log log;
        Rig rig(rtu_config(), nullptr, &log);
        const std::string write = rtu(1, "06 0000 0007");
        for (int i = 0; i < 6; ++i) {
            const bool reads = i < 2;  // from these it is known that the line echoes, however late
            rig.sent.clear();
            rig.hear(reads ? kRead : write);
            rig.run(kSilence);
            ASSERT_EQ(rig.sent, reads ? kReadAnswer : write);
            rig.run(latency);
            rig.hear(rig.sent, static_cast<std::size_t>(1 + 3 * (i % 3)));
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
    rig.hear(rig.sent);
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
    rig.hear(kReadAnswer);
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
    rig.hear(rtu(1, "03 0410 0001"));  // shares 01 03 04 with the answer
    rig.run(20ms);
    EXPECT_EQ(rig.sent, rtu(1, "83 02"));
}

TEST(SerialSlave, NoiseThatBeginsLikeTheAnswerCostsNothing) {
    Rig rig(rtu_config());
    EXPECT_EQ(rig.exchange(kRead, kSilence), kReadAnswer);
    rig.hear("01");
    rig.run(5ms);
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
}

TEST(SerialSlave, ANewRequestTakesTheWaitingOnesPlaceOrIsDropped) {
    for (const bool finish_first : {false, true}) {
        SerialConfig config = rtu_config();
        config.turnaround = 50ms;
        config.finish_first = finish_first;
        Rig rig(config);
        rig.hear(kRead);
        rig.run(20ms);
        rig.hear(rtu(1, "03 0001 0001"));
        rig.run(100ms);
        EXPECT_EQ(rig.sent, finish_first ? kReadAnswer : rtu(1, "03 02 0001"));
        EXPECT_EQ(rig.slave.counters().unanswered, 1u);
    }
}

TEST(SerialSlave, AnswersOfSeveralUnitsKeepTheSilenceBetweenThem) {
    SerialConfig config = rtu_config();
    config.turnaround = 30ms;
    Rig rig(config);
    rig.hear(rtu(1, "03 0001 0001"));
    rig.run(2ms);
    rig.hear(rtu(2, "03 0002 0001"));
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
    rig.hear(request);
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
    rig.hear(kRead);
    rig.slave.on_link(rig.now, false);
    rig.run(50ms);
    rig.hear(kRead);
    rig.run(50ms);
    EXPECT_EQ(rig.sent, "");
    rig.hear(kRead.substr(0, 9));
    rig.slave.on_link(rig.now, true);
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    EXPECT_EQ(rig.slave.counters().unanswered, 1u);
}

TEST(SerialSlave, TellsItsTraffic) {
    Log log;
    Rig rig(rtu_config(), nullptr, &log);
    rig.exchange(kRead);
    rig.exchange(rtu(7, "03 0000 0001"));
    rig.exchange("01 03 00 10 00 02 00 00");
    EXPECT_EQ(log.lines, (std::vector<std::string>{"received 03 00 10 00 02", "sent 03 04 00 10 00 11",
                                                   "received 03 00 00 00 01", "checksum"}));
}

std::string ascii(std::string_view text) {
    return hex(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

// 44-47
TEST(SerialSlave, Ascii) {
    struct Row {
        const char* what;
        std::string input;
        bool answered;
        wire::FrameFault fault;
    };
    const Row kRows[] = {
        {"good", ":010300100002EA\r\n", true, wire::FrameFault::none},
        {"lower case", ":010300100002ea\r\n", true, wire::FrameFault::none},
        {"':' inside a frame", ":0103001:010300100002EA\r\n", true, wire::FrameFault::none},
        {"noise before", "\r\nzz\n:010300100002EA\r\n", true, wire::FrameFault::none},
        {"odd digits", ":01030010002EA\r\n", false, wire::FrameFault::bad_character},
        {"no digit", ":0103G0100002EA\r\n", false, wire::FrameFault::bad_character},
        {"bad LRC", ":010300100002EB\r\n", false, wire::FrameFault::checksum},
        {"CR without LF", ":010300100002EA\r:", false, wire::FrameFault::bad_character},
        {"over 513 characters", ":" + std::string(600, '0') + "\r\n", false, wire::FrameFault::too_long},
        {"broadcast read", ":000300100002EB\r\n", false, wire::FrameFault::none},
    };
    const std::string good = ascii(":010300100002EA\r\n");
    const std::string answer = frame(wire::Framing::ascii, 1, "03 04 0010 0011");
    for (const auto& [what, input, answered, fault] : kRows) {
        Rig rig(ascii_config());
        EXPECT_EQ(rig.exchange(ascii(input)), answered ? answer : "") << what;
        EXPECT_TRUE(fault == wire::FrameFault::none || rig.slave.counters().of(fault) >= 1) << what;
        rig.run(2s);
        EXPECT_EQ(rig.exchange(good), answer) << "after " << what;
    }
}

TEST(SerialSlave, AsciiPauseOverASecondDropsTheFrame) {
    for (const Duration pause : {900ms, 1100ms}) {
        Rig rig(ascii_config());
        rig.hear(ascii(":01030010"));
        rig.run(pause);
        rig.hear(ascii("0002EA\r\n"));
        rig.run(100ms);
        EXPECT_EQ(rig.sent.empty(), pause > 1s);
    }
}

TEST(SerialSlave, AsciiWithoutTurnaroundAnswersAtOnce) {
    Rig rig(ascii_config());
    rig.hear(ascii(":010300100002EA\r\n"));
    EXPECT_EQ(rig.sent, frame(wire::Framing::ascii, 1, "03 04 0010 0011"));
}

// Whatever comes, what goes out is a good frame, and after a silence a good request is served.
RC_GTEST_PROP(SerialSlave, NoiseNeverMakesItDeaf, ()) {
    Rig rig(rtu_config());
    const auto noise = *rc::gen::container<std::vector<std::vector<std::uint8_t>>>(
        rc::gen::container<std::vector<std::uint8_t>>(
            rc::gen::weightedOneOf<std::uint8_t>({{1, rc::gen::element<std::uint8_t>(0, 1, 3, 6, 16, 0x83)},
                                                  {1, rc::gen::arbitrary<std::uint8_t>()}})));
    for (const auto& burst : noise) {
        rig.hear(hex(burst), *rc::gen::inRange<std::size_t>(1, 20));
        rig.run(*rc::gen::element<Duration>(100us, 1ms, 2ms, 10ms));
    }
    rig.run(20ms);
    RC_ASSERT(rig.exchange(kRead) == kReadAnswer);
}

}  // namespace
}  // namespace takt::serve
