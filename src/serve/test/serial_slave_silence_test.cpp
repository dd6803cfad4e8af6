// The meaning of silences, on lines whose bytes arrive in time, in bursts or late.
#include "serial_rig.hpp"

namespace takt::serve {
namespace {

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

}  // namespace
}  // namespace takt::serve
