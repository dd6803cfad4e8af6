// The start of an instrument, its settings and its restarts.
#include "instrument_bench.hpp"

namespace takt::endpoint {
namespace instrument_start_test {

using namespace test;

TEST(InstrumentStart, CommandsGoOutInOrderBeforeRequests) {
    Bench bench;
    EXPECT_EQ(bench.take(), "INIT ");
    EXPECT_EQ(bench.engine.state(), InstrumentState::starting);
    bench.receive("what\rOK\r");
    EXPECT_EQ(bench.take(), "MODE W ") << "MODE has no answer";
    EXPECT_EQ(bench.engine.state(), InstrumentState::ready);
    bench.receive("W5\r");
    EXPECT_EQ(std::get<std::int64_t>(bench.engine.reading("weight").value), 5);
    EXPECT_EQ(bench.events, std::vector{Kind::ready});
}

TEST(InstrumentStart, FailsAfterItsAttemptsAndBeginsAgain) {
    for (const bool refuses : {false, true}) {
        Bench bench;
        if (refuses) bench.receive("ERR 1\r");
        bench.pass(refuses ? 100ms : 200ms);
        if (refuses) bench.receive("ERR 1\r");
        bench.pass(100ms);
        EXPECT_EQ(bench.take(), "INIT INIT ") << refuses;
        EXPECT_EQ(bench.engine.state(), InstrumentState::start_failed);
        bench.receive("OK\r");  // too late
        bench.pass(refuses ? 900ms : 1s);
        EXPECT_EQ(bench.take(), "") << "no request before the start";
        bench.pass(1s);
        EXPECT_EQ(bench.take(), "INIT ");
        bench.receive("OK\r");
        EXPECT_EQ(bench.take(), "MODE W ");
        EXPECT_EQ(bench.engine.counters().failed_starts, 1u);
        EXPECT_EQ(bench.events, (std::vector{Kind::start_failed, Kind::ready}));
    }
}

TEST(InstrumentStart, ThePauseIsKept) {
    auto settings = scale();
    settings.start[0].confirmation.pause = 30ms;
    Bench bench(settings);
    bench.receive("OK\r");
    EXPECT_EQ(bench.take(), "INIT ");
    bench.pass(29ms);
    EXPECT_EQ(bench.take(), "");
    bench.pass(1ms);
    EXPECT_EQ(bench.take(), "MODE W ");
}

TEST(InstrumentStart, IsRepeatedWhenTheInstrumentRestarts) {
    struct Row {
        const char* name;
        std::function<void(Bench&)> restart;
        std::uint64_t resets;
    };
    const Row rows[] = {
        {"the connection",
         [](Bench& bench) {
             bench.link(false);
             EXPECT_EQ(bench.engine.state(), InstrumentState::down);
             bench.pass(1s);
             bench.link(true);
         },
         0},
        {"its line while it rests",
         [](Bench& bench) {
             bench.receive("noise\rREADY v2\r");
             bench.receive("more of it\r");
             bench.pass(99ms);
             EXPECT_EQ(bench.take(), "") << "it may send more than its line";
             bench.pass(1ms);
         },
         1},
        {"its line while it is asked",
         [](Bench& bench) {
             bench.pass(1s);
             EXPECT_EQ(bench.take(), "W ");
             bench.receive("REA");
             bench.receive("DY\r");
             bench.pass(100ms);
         },
         1},
        {"silence",
         [](Bench& bench) {
             bench.pass(4s);
             EXPECT_EQ(bench.take(), "W W W W ");
             EXPECT_EQ(bench.engine.state(), InstrumentState::silent);
             bench.receive("W77\r");
             EXPECT_EQ(std::get<std::int64_t>(bench.engine.reading("weight").value), 1)
                 << "measured before the start";
         },
         1},
    };
    for (const auto& [name, restart, resets] : rows) {
        SCOPED_TRACE(name);
        Bench bench;
        bench.make_ready();
        EXPECT_TRUE(bench.write(0, "5"));
        bench.receive("OK\r");
        EXPECT_TRUE(bench.write(2, "7"));
        bench.receive("U=7\r");
        EXPECT_TRUE(bench.write(1, "9"));
        bench.receive("OK\r");
        EXPECT_TRUE(bench.write(0, "6"));
        bench.receive("OK\r");
        EXPECT_EQ(bench.take(), "T5 U7 U? Z9 T6 ");
        EXPECT_EQ(bench.take_results(), "tare5 done; unit7 done; zero9 done; tare6 done; ");
        restart(bench);
        bench.receive("OK\r");
        EXPECT_EQ(bench.take(), "INIT MODE T6 ") << "settings, their last values, no actions";
        bench.receive("OK\r");
        bench.receive("U=7\r");
        EXPECT_EQ(bench.take(), "U7 U? W ");
        EXPECT_EQ(bench.engine.state(), InstrumentState::ready);
        EXPECT_EQ(bench.engine.counters().restored, 2u);
        EXPECT_EQ(bench.engine.counters().resets, resets);
    }
}

TEST(InstrumentStart, AnAnswerIsNoLineOfAReset) {
    auto settings = scale();
    settings.reset = line("{*}1");
    Bench bench(settings);
    bench.receive("OK\r");
    bench.receive("W1\r");
    bench.take();
    bench.pass(1s);
    bench.receive("W1\r");
    EXPECT_EQ(bench.take(), "W ");
    EXPECT_EQ(bench.engine.counters().resets, 0u);
}

TEST(InstrumentStart, ARestartInsideTheStartBeginsItAnew) {
    Bench bench;
    bench.receive("OK\r");
    bench.take();
    bench.receive("READY\r");
    bench.pass(100ms);
    bench.receive("READY\r");
    bench.pass(100ms);
    EXPECT_EQ(bench.take(), "INIT INIT ");
    bench.receive("OK\r");
    EXPECT_EQ(bench.take(), "MODE W ");
}

TEST(InstrumentStart, ASettingThatIsRefusedIsForgotten) {
    Bench bench;
    bench.make_ready();
    bench.write(0, "5");
    bench.receive("OK\r");
    for (int i = 0; i < 2; ++i) {
        bench.link(false);
        bench.take();
        bench.link(true);
        bench.receive("OK\r");
        if (i == 0) bench.receive("ERR\r");
        EXPECT_EQ(bench.take(), i == 0 ? "INIT MODE T5 W " : "INIT MODE W ");
    }
    EXPECT_EQ(std::ranges::count(bench.events, Kind::setting_dropped), 1);
}

TEST(InstrumentStart, ASettingThatIsNotAnsweredFailsTheStart) {
    Bench bench;
    bench.make_ready();
    bench.write(0, "5");
    bench.receive("OK\r");
    bench.link(false);
    bench.link(true);
    bench.receive("OK\r");
    bench.pass(100ms);
    EXPECT_EQ(bench.engine.state(), InstrumentState::start_failed);
    bench.take();
    bench.pass(2s);
    bench.receive("OK\r");
    bench.receive("OK\r");
    EXPECT_EQ(bench.take(), "INIT MODE T5 W ");
}

TEST(InstrumentStart, OneThatSendsByItselfIsStartedToo) {
    auto settings = scale();
    settings.exchanges = {{.request = "", .answer = line("W{weight}")}};
    Bench bench(settings);
    EXPECT_EQ(bench.take(), "INIT ");
    bench.receive("W1\rW2\rOK\rW3\rW4\r");
    EXPECT_EQ(bench.take(), "MODE ");
    EXPECT_FALSE(bench.engine.reading("weight").at) << "measured before the start";
    bench.receive("4\rW5\r");
    EXPECT_EQ(std::get<std::int64_t>(bench.engine.reading("weight").value), 5);
    bench.write(0, "8");
    EXPECT_EQ(bench.take(), "T8 ");
    bench.receive("W6\rOK\rW7\r");
    EXPECT_EQ(bench.take_results(), "tare8 done; ");
    EXPECT_EQ(std::get<std::int64_t>(bench.engine.reading("weight").value), 7);
    bench.write(0, "9");
    bench.pass(300ms);
    EXPECT_EQ(bench.take_results(), "tare9 no_answer; ");
    bench.receive("READY\r");
    bench.pass(100ms);
    EXPECT_EQ(bench.take(), "T9 INIT ");
}

}  // namespace instrument_start_test
}  // namespace takt::endpoint
