// Commands with values.
#include "instrument_bench.hpp"

namespace takt::endpoint {
namespace instrument_commands_test {

using namespace test;

TEST(InstrumentCommands, TheResultIsTheInstrumentsAnswer) {
    struct Row {
        std::size_t command;
        std::vector<const char*> answers;
        const char* sent;
        const char* expected;
    };
    const Row rows[] = {
        {0, {"OK\r"}, "T5 ", "tare5 done; "},
        {0, {"T5\r", "OK\r"}, "T5 ", "tare5 done; "},  // with its echo
        {0, {"ERR 7\r"}, "T5 ", "tare5 refused; "},
        {0, {"what\r"}, "T5 ", "tare5 no_answer; "},
        {0, {"O"}, "T5 ", "tare5 no_answer; "},
        {0, {}, "T5 ", "tare5 no_answer; "},
        {2, {"U=5\r"}, "U5 U? ", "unit5 done; "},
        {2, {"U=5.0\r"}, "U5 U? ", "unit5 done; "},
        {2, {"U=4\r"}, "U5 U? ", "unit5 differs; "},
        {2, {}, "U5 U? ", "unit5 no_answer; "},
    };
    for (const auto& [command, answers, sent, expected] : rows) {
        Bench bench;
        bench.make_ready();
        bench.write(command, "5");
        for (const char* const answer : answers) bench.receive(answer);
        bench.pass(300ms);
        EXPECT_EQ(bench.take_results(), expected) << expected;
        EXPECT_EQ(bench.take(), sent);
    }
}

TEST(InstrumentCommands, AnAnswerMayRepeatTheValue) {
    auto settings = scale();
    settings.commands[0].confirmation.answer = line("T{value} OK");
    for (const auto& [answer, expected] :
         {std::pair("T5.00 OK\r", "tare5 done; "), std::pair("T6 OK\r", "tare5 differs; ")}) {
        Bench bench(settings);
        bench.make_ready();
        bench.write(0, "5");
        bench.receive(answer);
        EXPECT_EQ(bench.take_results(), expected);
    }
}

TEST(InstrumentCommands, AttemptsAreLimited) {
    auto settings = scale();
    settings.commands[0].confirmation.attempts = 3;
    settings.silent_after = 0;
    Bench bench(settings);
    bench.make_ready();
    bench.write(0, "5");
    bench.pass(900ms);
    EXPECT_EQ(bench.take(), "T5 T5 T5 ");
    EXPECT_EQ(bench.take_results(), "tare5 no_answer; ");
}

TEST(InstrumentCommands, AreExecutedInOrderBetweenTheRequests) {
    Bench bench;
    bench.make_ready();
    bench.pass(990ms);
    for (const char* const value : {"1", "2", "3"}) EXPECT_TRUE(bench.write(0, value));
    bench.pass(10ms);
    for (int i = 0; i < 3; ++i) bench.receive(i == 1 ? "W1\r" : "OK\r");
    EXPECT_EQ(bench.take(), "T1 W T2 T3 ") << "a due request goes between them";
    bench.receive("OK\r");
    EXPECT_EQ(bench.take_results(), "tare1 done; tare2 done; tare3 done; ");
}

TEST(InstrumentCommands, TheQueueIsLimited) {
    Bench bench;
    bench.make_ready();
    for (std::size_t i = 0; i < InstrumentEngine::kMostCommands; ++i) EXPECT_TRUE(bench.write(0, "1"));
    EXPECT_FALSE(bench.write(0, "2"));
    EXPECT_EQ(bench.engine.counters().busy, 1u);
    bench.receive("OK\r");
    EXPECT_TRUE(bench.write(0, "3"));
}

TEST(InstrumentCommands, OneThatExpiresBeforeItIsSentIsNeverSent) {
    struct Row {
        const char* name;
        std::function<void(Bench&)> hold;
    };
    const Row rows[] = {
        {"down", [](Bench& bench) { bench.link(false); }},
        {"starting",
         [](Bench& bench) {
             bench.engine.on_link(bench.now, false);
             bench.link(true);
         }},
    };
    for (const auto& [name, hold] : rows) {
        SCOPED_TRACE(name);
        auto settings = scale();
        settings.start[0].confirmation.timeout = 3s;
        Bench bench(settings);
        bench.make_ready();
        hold(bench);
        bench.take();
        EXPECT_TRUE(bench.write(0, "5"));
        bench.pass(999ms);
        EXPECT_EQ(bench.take_results(), "");
        bench.pass(1ms);
        EXPECT_EQ(bench.take_results(), "tare5 expired; ");
        bench.link(false);
        bench.link(true);
        bench.receive("OK\r");
        EXPECT_FALSE(bench.said.contains("T5")) << bench.said;
    }
}

TEST(InstrumentCommands, OneThatIsKnownNotToAnswerRefusesAtOnce) {
    struct Row {
        const char* name;
        std::function<void(Bench&)> make_deaf;
        InstrumentState state;
    };
    const Row rows[] = {
        {"down",
         [](Bench& bench) {
             bench.link(false);
             bench.pass(1s);
             bench.link(false);
         },
         InstrumentState::down},
        {"start failed",
         [](Bench& bench) {
             bench.link(false);
             bench.link(true);
             bench.pass(400ms);
         },
         InstrumentState::start_failed},
        {"silent", [](Bench& bench) { bench.pass(4s); }, InstrumentState::silent},
    };
    for (const auto& [name, make_deaf, state] : rows) {
        SCOPED_TRACE(name);
        Bench bench;
        bench.make_ready();
        make_deaf(bench);
        EXPECT_EQ(bench.engine.state(), state);
        EXPECT_FALSE(bench.write(0, "5"));
        EXPECT_EQ(bench.engine.counters().unanswered, 1u);
    }
    Bench never(scale(), false);
    EXPECT_TRUE(never.write(0, "5")) << "its link may come up";
    never.pass(1s);
    EXPECT_EQ(never.take_results(), "tare5 expired; ");
    EXPECT_FALSE(never.write(0, "5"));
}

TEST(InstrumentCommands, ARestartRacesWithAWrite) {
    struct Row {
        std::size_t command;
        const char* results;
        const char* sent;
    };
    const Row rows[] = {
        {0, "", "INIT MODE T1 T5 "},                  // the confirmed value, then the new one
        {1, "zero5 no_answer; ", "INIT MODE T1 W "},  // it may have been done: it is not repeated
    };
    for (const bool by_line : {false, true})
        for (const auto& [command, results, sent] : rows) {
            Bench bench;
            bench.make_ready();
            bench.write(0, "1");
            bench.receive("OK\r");
            bench.take_results();
            bench.write(command, "5");
            bench.take();
            if (by_line) {
                bench.receive("READY\r");
                bench.pass(100ms);
            } else {
                bench.link(false);
                bench.link(true);
            }
            EXPECT_EQ(bench.take_results(), results);
            bench.receive("OK\r");
            bench.receive("OK\r");
            EXPECT_EQ(bench.take(), sent);
            bench.receive(command == 0 ? "OK\r" : "W1\r");
            EXPECT_EQ(bench.take_results(), command == 0 ? "tare5 done; " : "");
        }
}

TEST(InstrumentCommands, AnAnswerAfterTheExpiryStillConfirmsTheValue) {
    auto settings = scale();
    settings.commands[0].expires = 50ms;
    Bench bench(settings);
    bench.make_ready();
    bench.write(0, "5");
    bench.pass(60ms);
    EXPECT_EQ(bench.take_results(), "tare5 expired; ");
    bench.receive("OK\r");
    EXPECT_EQ(bench.take_results(), "");
    bench.link(false);
    bench.take();
    bench.link(true);
    bench.receive("OK\r");
    EXPECT_EQ(bench.take(), "INIT MODE T5 ");
}

TEST(InstrumentCommands, OnlyAConfirmedValueIsASetting) {
    for (const char* const answer : {"ERR\r", "what\r"}) {
        Bench bench;
        bench.make_ready();
        bench.write(0, "1");
        bench.receive("OK\r");
        bench.write(0, "2");
        bench.receive(answer);
        bench.pass(200ms);
        bench.link(false);
        bench.take();
        bench.link(true);
        bench.receive("OK\r");
        EXPECT_EQ(bench.take(), "INIT MODE T1 ") << answer;
    }
}

TEST(InstrumentCommands, AnAnswerIsFollowedByTheReadingBack) {
    struct Row {
        const char* value;
        const char* expected;
    };
    for (const auto& [value, expected] : {Row{"T=5\r", "tare5 done; "}, Row{"T=6\r", "tare5 differs; "}}) {
        auto settings = scale();
        settings.commands[0].read_back = model::Exchange{.request = "T?\r", .answer = line("T={value}")};
        Bench bench(settings);
        bench.make_ready();
        bench.write(0, "5");
        bench.receive("OK\r");
        EXPECT_EQ(bench.take_results(), "");
        bench.receive(value);
        EXPECT_EQ(bench.take(), "T5 T? ");
        EXPECT_EQ(bench.take_results(), expected);
    }
}

TEST(InstrumentCommands, AnExpiredOneIsNotRepeated) {
    for (const auto expires : {50ms, 150ms}) {  // in flight; in the silence before the next attempt
        auto settings = scale();
        settings.commands[0].confirmation.attempts = 3;
        settings.commands[0].expires = expires;
        Bench bench(settings);
        bench.make_ready();
        bench.write(0, "5");
        bench.pass(500ms);
        EXPECT_EQ(bench.take(), "T5 ");
        EXPECT_EQ(bench.take_results(), "tare5 expired; ");
        EXPECT_EQ(bench.engine.counters().unanswered, 1u);
    }
}

TEST(InstrumentCommands, OneThatWaitsWhenTheSilenceBeginsIsSentAfterTheStart) {
    auto settings = scale();
    settings.commands[0].expires = 10s;
    Bench bench(settings);
    bench.make_ready();
    bench.pass(3s);
    EXPECT_EQ(bench.take(), "W W W ");
    EXPECT_TRUE(bench.write(0, "5"));
    bench.pass(1s);
    EXPECT_EQ(bench.engine.state(), InstrumentState::silent);
    EXPECT_EQ(bench.take(), "W ");
    bench.receive("W9\r");
    bench.receive("OK\r");
    EXPECT_EQ(bench.take(), "INIT MODE T5 ");
    bench.receive("OK\r");
    EXPECT_EQ(bench.take_results(), "tare5 done; ");
}

}  // namespace instrument_commands_test
}  // namespace takt::endpoint
