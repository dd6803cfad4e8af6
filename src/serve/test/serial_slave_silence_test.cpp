// The meaning of silences, on lines whose bytes arrive in time, in bursts or late.
#include "serial_rig.hpp"

namespace takt::serve {
namespace serial_slave_silence_test {

TEST(SerialSlave, WaitsForSilenceBehindSurplusBytes) {
    Rig rig(rtu_config());
    rig.receive(kRead);
    rig.run(1ms);
    rig.receive("55");
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
    // 14 characters at a time: the second chunk arrives 14 character times after the first, far more than
    // t3.5.
    Rig rig(rtu_config());
    const std::string write = rtu(1, "10 0010 0004 08 0001 0002 0003 0004");
    rig.sent.clear();
    rig.receive(write, 14);
    rig.run(20ms);
    EXPECT_EQ(rig.sent, rtu(1, "10 0010 0004"));
}

TEST(SerialSlave, AnAnswerThatNoiseHasDelayedTooLongIsNotSent) {
    for (const Duration noise : {400ms, 600ms}) {
        Rig rig(rtu_config());
        rig.receive(kRead);
        for (const Instant end = rig.now + noise; rig.now < end; rig.run(1ms)) rig.receive("55");
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
        rig.receive(request.substr(0, 12));
        rig.run(1000us);
        rig.receive(request.substr(12));
        rig.run(20ms);
        EXPECT_EQ(rig.sent, strict ? "" : kReadAnswer);
        EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::pause), strict ? 1u : 0u);
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    }
}

TEST(SerialSlave, FramesInLumpsAreServedUnlessItIsStrict) {
    for (const bool strict : {false, true})
        for (const Duration pause : {1ms, 2ms, 5ms, 16ms, 25ms})
            for (const std::size_t cut : {3U, 6U, 12U, 18U, 21U}) {
                SerialConfig config = rtu_config();
                config.strict = strict;
                Rig rig(config);
                rig.receive(kRead.substr(0, cut));
                rig.run(pause);
                rig.receive(kRead.substr(cut));
                rig.run(kSilence);
                EXPECT_EQ(rig.sent, strict ? "" : kReadAnswer) << pause.count() << " ns behind " << cut;
                rig.run(50ms);
                EXPECT_EQ(rig.exchange(kRead), kReadAnswer) << "and the next";
            }
}

TEST(SerialSlave, APieceOfAFrameIsNoPartOfTheNext) {
    for (const Duration pause : {2ms, 10ms, 40ms})
        for (std::size_t cut = 3; cut < kRead.size(); cut += 3) {
            Rig rig(rtu_config());
            rig.receive(kRead.substr(0, cut));
            rig.run(pause);
            EXPECT_EQ(rig.exchange(kRead), kReadAnswer) << pause.count() << " ns behind " << cut;
        }
}

TEST(SerialSlave, ALateAdapterCutsFramesAndIsNotTooSlowForTheNext) {
    SerialConfig config = rtu_config();
    config.frame_silence = 20ms;
    Rig rig(config);
    for (int i = 0; i < 5; ++i) {
        rig.sent.clear();
        rig.receive(kRead.substr(0, 9));
        rig.run(16ms);
        rig.receive(kRead.substr(9));
        rig.run(kSilence);
        EXPECT_EQ(rig.sent, kReadAnswer) << i;
        rig.run(wire::transmission_time(kFast, 9) + kSilence);
    }
}

const std::string kLong = rtu(1, [] {  // 89 bytes: a write of 40 registers
    std::string text = "10 0000 0028 50";
    for (int i = 0; i < 40; ++i) text += " 0102";
    return text;
}());

/// The bytes of the frame, one each `pace`.
void dribble(Rig& rig, const std::string& text, Duration pace) {
    for (const std::uint8_t byte : bytes(text)) {
        rig.slave.on_bytes(rig.now, Bytes(&byte, 1));
        rig.run(pace);
    }
}

std::uint64_t dropped(const Rig& rig) {
    std::uint64_t all = 0;
    for (const std::uint64_t count : rig.slave.counters().faults) all += count;
    return all;
}

TEST(SerialSlave, ASlowFrameIsDroppedAndCountedOnce) {
    ASSERT_EQ(bytes(kLong).size(), 89u);
    Log log;
    Rig rig(rtu_config(), nullptr, &log);
    for (std::uint64_t frame = 1; frame <= 2; ++frame) {
        dribble(rig, kLong, 25ms);
        rig.run(100ms);
        EXPECT_EQ(rig.sent, "") << "2.2 s are above the default of 2 s";
        EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::too_slow), frame);
        EXPECT_EQ(dropped(rig), frame);
    }
    EXPECT_EQ(log.lines, (std::vector<std::string>{"too_slow", "too_slow"}));
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
}

TEST(SerialSlave, TheFrameTimeoutIsASetting) {
    struct Row {
        Duration frame_timeout, pace;
        bool served;
    };
    constexpr Row kRows[] = {{0ms, 20ms, true}, {3s, 25ms, true}, {1s, 20ms, false}, {5ms, 87us, false}};
    for (const auto& [frame_timeout, pace, served] : kRows) {
        SerialConfig config = rtu_config();
        config.frame_timeout = frame_timeout;
        Rig rig(config);
        dribble(rig, kLong, pace);
        rig.run(100ms);
        EXPECT_EQ(rig.sent != "", served) << frame_timeout.count();
        EXPECT_EQ(dropped(rig), served ? 0u : 1u) << frame_timeout.count();
    }
}

TEST(SerialSlave, TheByteTimeoutIsASetting) {
    struct Row {
        Duration byte_timeout, pause;
        bool served;
    };
    constexpr Row kRows[] = {{0ms, 29ms, true}, {0ms, 31ms, false}, {100ms, 90ms, true}, {5ms, 6ms, false}};
    for (const auto& [byte_timeout, pause, served] : kRows) {
        SerialConfig config = rtu_config();
        config.byte_timeout = byte_timeout;
        Rig rig(config);
        rig.receive(kRead.substr(0, 12));
        rig.run(pause);
        rig.receive(kRead.substr(12));
        rig.run(200ms);
        EXPECT_EQ(rig.sent, served ? kReadAnswer : "") << byte_timeout.count();
        EXPECT_EQ(dropped(rig), served ? 0u : 1u) << byte_timeout.count();
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    }
}

TEST(SerialSlave, ABrokenFrameInChunksIsCountedOnce) {
    std::string broken = kLong;
    broken.back() = broken.back() == '0' ? '1' : '0';
    for (const std::size_t chunk : {1u, 3u, 14u, 64u}) {
        Rig rig(rtu_config());
        const auto data = bytes(broken);
        for (std::size_t done = 0; done < data.size(); done += chunk) {
            rig.slave.on_bytes(rig.now, Bytes(data).subspan(done, std::min(chunk, data.size() - done)));
            rig.run(16ms);
        }
        rig.run(50ms);
        EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::checksum), 1u) << chunk;
        EXPECT_EQ(dropped(rig), 1u) << chunk;
    }
}

TEST(SerialSlave, ShortPiecesOfABrokenFrameAreCountedOnce) {
    Rig rig(rtu_config());
    for (std::uint64_t frame = 1; frame <= 2; ++frame) {
        dribble(rig, kRead, 40ms);
        rig.run(3s);
        EXPECT_EQ(rig.slave.counters().of(wire::FrameFault::too_short), frame);
        EXPECT_EQ(dropped(rig), frame);
    }
    EXPECT_EQ(rig.exchange(kRead), kReadAnswer);
    rig.exchange("55");
    EXPECT_EQ(dropped(rig), 2u) << "not before the byte time-out";
    rig.run(30ms);
    EXPECT_EQ(dropped(rig), 3u) << "a good frame in between ends the broken one";
}

// A broken frame is counted once, however long the pauses are that cut it. Silences of `byte_timeout` + 300
// ms separate frames, and so does the length of a whole frame.
TEST(SerialSlave, BrokenFramesAreCountedBySilenceAndLength) {
    std::string bad = kRead;
    bad.back() = bad.back() == '0' ? '1' : '0';
    const auto cut = [](const std::string& text, std::vector<std::size_t> lengths) {
        std::vector<std::string> pieces;
        std::string rest = hex(bytes(text));
        for (const std::size_t length : lengths) {
            pieces.push_back(rest.substr(0, 3 * length));
            rest.erase(0, 3 * length);
        }
        pieces.push_back(rest);
        return pieces;
    };
    const auto single = [&](const std::string& text) {
        return cut(text, std::vector<std::size_t>(bytes(text).size() - 1, 1));
    };
    struct Row {
        const char* name;
        std::vector<std::string> pieces;
        Duration pause;
        std::uint64_t counted;  // of two such frames, each followed by 500 ms of silence
        Duration byte_timeout = 0ms;
        bool strict = false;
    };
    const Row rows[] = {
        {"one pause of 100 ms", cut(kLong, {40}), 100ms, 2},
        {"four pauses of 100 ms", cut(kLong, {20, 20, 20, 20}), 100ms, 2},
        {"a short piece first", cut(kRead, {3}), 100ms, 2},
        {"each byte after 60 ms, 5.3 s in all", single(kLong), 60ms, 2},
        {"each byte after 35 ms", single(kRead), 35ms, 2},
        {"each byte after 35 ms, strict", single(kRead), 35ms, 2, 0ms, true},
        {"pauses just below the silence", cut(kLong, {20, 20, 20, 20}), 320ms, 2},
        {"pauses just above the silence", cut(kLong, {20, 20, 20, 20}), 340ms, 10},
        {"the silence grows with the byte time-out", cut(kLong, {20, 20, 20, 20}), 380ms, 2, 100ms},
        {"whole frames, each with a wrong checksum", {bad, bad, bad}, 50ms, 6},
        {"a piece, then a whole frame", {"01 03 00", bad}, 50ms, 4},
    };
    for (const auto& row : rows) {
        SerialConfig config = rtu_config();
        config.byte_timeout = row.byte_timeout;
        config.strict = row.strict;
        Rig rig(config);
        for (int frame = 0; frame < 2; ++frame) {
            for (const auto& piece : row.pieces) {
                rig.receive(piece);
                rig.run(row.pause);
            }
            rig.run(500ms);
        }
        EXPECT_EQ(rig.sent, "") << row.name;
        EXPECT_EQ(dropped(rig), row.counted) << row.name;
        EXPECT_EQ(rig.exchange(kRead), kReadAnswer) << row.name;
    }
}

TEST(SerialSlave, AGoodFrameInChunksIsNoFault) {
    Rig rig(rtu_config());
    dribble(rig, kRead, 20ms);
    EXPECT_EQ(rig.sent, kReadAnswer);
    rig.run(100ms);
    EXPECT_EQ(dropped(rig), 0u);
}

// A diagnostic counter that the next request reads includes the broken frame.
TEST(SerialSlave, ABrokenFrameIsCountedBeforeTheNextRequestIsServed) {
    Log log;
    Rig rig(rtu_config(), nullptr, &log);
    rig.exchange("01 03 00 10 00 02 00 00", 5ms);
    EXPECT_EQ(dropped(rig), 0u) << "more bytes may follow";
    rig.exchange(kRead);
    ASSERT_EQ(log.lines.size(), 3u);
    EXPECT_EQ(log.lines[0], "checksum");
}

}  // namespace serial_slave_silence_test
}  // namespace takt::serve
