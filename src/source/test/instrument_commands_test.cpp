// The start of an instrument, and commands with values.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "takt/source/instrument_engine.hpp"

namespace takt::source {
namespace {

using namespace std::chrono_literals;
using Kind = InstrumentEvent::Kind;

model::AnswerFormat line(const char* pattern) {
    model::AnswerFormat made;
    made.until = "\r";
    made.pattern = *model::parse_template(pattern);
    return made;
}

model::StartCommand start(const char* request, const char* answer) {
    model::StartCommand made{.request = request};
    if (answer != nullptr) made.confirmation.answer = line(answer);
    made.confirmation.refused = line("ERR{*}");
    made.confirmation.timeout = 100ms;
    made.confirmation.attempts = 2;
    return made;
}

model::InstrumentCommand command(const char* name, const char* request, const char* answer) {
    model::InstrumentCommand made{.name = name};
    made.request = *model::parse_template(request);
    if (answer != nullptr) made.confirmation.answer = line(answer);
    made.confirmation.refused = line("ERR{*}");
    made.confirmation.timeout = 100ms;
    made.expires = 1s;
    return made;
}

/// Asks W each second; tare is a setting, `zero` an action, `unit` is read back.
model::Instrument scale() {
    model::Instrument made{.name = "scale"};
    made.every = 1s;
    made.timeout = 100ms;
    made.exchanges.push_back({.request = "W\r", .answer = line("W{weight}")});
    made.start = {start("INIT\r", "OK"), start("MODE\r", nullptr)};
    made.start_retry = 2s;
    made.reset = line("READY{*}");
    made.commands = {command("tare", "T{value}\\r", "OK"), command("zero", "Z{value}\\r", "OK"),
                     command("unit", "U{value}\\r", nullptr)};
    made.commands[1].restore = false;
    made.commands[2].confirmation.refused.reset();
    made.commands[2].read_back = model::Exchange{.request = "U?\r", .answer = line("U={value}")};
    return made;
}

std::string_view word(WriteResult result) {
    constexpr std::string_view kWords[] = {"done", "refused", "differs", "no_answer", "expired"};
    return kWords[static_cast<std::size_t>(result)];
}

/// An engine and its time, moved by hand. `said` lists what it sends; `results` those of the commands.
struct Bench {
    explicit Bench(model::Instrument of = scale(), bool started = true)
        : settings(std::move(of)), engine(settings) {
        engine.set_observer([this](Instant, const InstrumentEvent& event) { events.push_back(event.kind); });
        if (!started) return;
        engine.on_link(now, true);
        run();
    }

    /// Takes what is to be sent now.
    void run() {
        for (auto sent = engine.transmit(now); !sent.empty(); sent = engine.transmit(now))
            said.append(reinterpret_cast<const char*>(sent.data()), sent.size() - 1).append(" ");
    }
    void pass(Duration time) {
        const Instant end = after(now, time);
        for (int i = 0; engine.next_wakeup() <= end; ++i) {
            ASSERT_LT(i, 1000) << "it does not come to rest";
            now = std::max(now, engine.next_wakeup());
            engine.on_tick(now);
            run();
        }
        now = end;
    }
    void receive(std::string_view text) {
        engine.on_bytes(now, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        run();
    }
    bool write(std::size_t command, const char* text) {
        const std::string name = settings.commands[command].name + text;
        const auto taken = engine.submit(now, command, text, [this, name](WriteResult result) {
            results.append(name).append(" ").append(word(result)).append("; ");
        });
        run();
        return taken.has_value();
    }
    void link(bool up) {
        engine.on_link(now, up);
        run();
    }
    std::string take() { return std::exchange(said, {}); }
    std::string take_results() { return std::exchange(results, {}); }
    /// Answers the start, and the first request.
    void make_ready() {
        receive("OK\r");
        receive("W1\r");
        EXPECT_EQ(engine.state(), InstrumentState::ready);
        take();
    }

    model::Instrument settings;
    InstrumentEngine engine;
    Instant now{std::chrono::hours(1)};
    std::string said;
    std::string results;
    std::vector<Kind> events;
};

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

TEST(InstrumentCommands, AnAnswerAfterTheExpiryStillTellsTheValue) {
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

// ---- an instrument that fails at random

/// Answers as the settings of scale() say. Forgets everything when it restarts.
struct Fake {
    bool initialised = false;
    std::string tare = "none";
    std::string executed;  // values of tare, in order, without those of a repetition
    std::string in;

    /// The answer to a byte, if it ends a request.
    std::string take(char c) {
        if (c != '\r') {
            in += c;
            return {};
        }
        const auto request = std::exchange(in, {});
        if (request == "W") return "W1\r";
        if (request == "MODE") return {};
        if (request == "INIT") {
            initialised = true;
            return "OK\r";
        }
        if (request[0] != 'T') return {};
        if (!initialised) return "ERR\r";
        tare = request.substr(1);
        return "OK\r";
    }
    void restart() { *this = {}; }
};

RC_GTEST_PROP(InstrumentCommands, NothingIsLostOrMixedUp, (const std::vector<std::uint8_t>& script)) {
    auto settings = scale();
    settings.commands[0].expires = 3s;
    InstrumentEngine engine(settings);
    Fake fake;
    Instant now{std::chrono::hours(1)};
    std::vector<WriteResult> results;
    std::string confirmed = "none";  // the value of the last confirmed write
    bool unknown = false;            // a later write had no clear result
    std::size_t written = 0;
    std::size_t expected_results = 0;
    bool answers = true;
    std::string reply;
    const auto serve = [&] {
        for (auto sent = engine.transmit(now); !sent.empty(); sent = engine.transmit(now))
            for (const auto byte : sent) reply += fake.take(static_cast<char>(byte));
    };
    const auto pass = [&](Duration time) {
        const Instant end = after(now, time);
        for (int i = 0; i < 10000; ++i) {
            if (!reply.empty() && answers) {
                const auto bytes = std::exchange(reply, {});
                engine.on_bytes(now, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
            } else if (engine.next_wakeup() <= end) {
                now = std::max(now, engine.next_wakeup());
                engine.on_tick(now);
            } else {
                break;
            }
            reply = answers ? reply : std::string();
            serve();
        }
        now = end;
    };
    engine.on_link(now, true);
    serve();
    for (const auto step : script) switch (step % 8) {
            case 0:
            case 1:
            case 2: {
                const auto value = std::to_string(++written);
                const auto taken = engine.submit(now, 0, value, [&, value](WriteResult result) {
                    results.push_back(result);
                    if (result == WriteResult::done) {
                        RC_ASSERT(fake.tare == value);
                        confirmed = value;
                        unknown = false;
                    } else if (result != WriteResult::refused) {
                        unknown = true;
                    }
                });
                if (taken) ++expected_results;
                serve();
                break;
            }
            case 3: {  // a restart with its line
                fake.restart();
                reply.clear();
                const std::string_view text = "READY\r";
                engine.on_bytes(now, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
                serve();
                break;
            }
            case 4:  // a restart of the connection
                fake.restart();
                reply.clear();
                engine.on_link(now, false);
                engine.on_link(now, true);
                serve();
                break;
            case 5: answers = !answers; break;
            case 6: pass(std::chrono::milliseconds(step)); break;
            default: pass(std::chrono::milliseconds(10 * step));
        }
    answers = true;
    pass(60s);
    RC_ASSERT(results.size() == expected_results);
    RC_ASSERT(engine.state() == InstrumentState::ready);
    RC_ASSERT(fake.initialised || confirmed == "none");
    if (!unknown) RC_ASSERT(fake.tare == confirmed || fake.tare == "none");
    if (!unknown && fake.initialised) RC_ASSERT(fake.tare == confirmed);
}

}  // namespace
}  // namespace takt::source
