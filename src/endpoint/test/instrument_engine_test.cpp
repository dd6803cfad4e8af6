#include "takt/endpoint/instrument_engine.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>

namespace takt::endpoint {
namespace instrument_engine_test {

using namespace std::chrono_literals;

Bytes bytes_of(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

model::Exchange exchange(std::string request, const char* pattern) {
    model::Exchange made;
    made.request = std::move(request);
    made.answer.until = "\r";
    made.answer.pattern = *model::parse_template(pattern);
    return made;
}

model::Instrument instrument(std::vector<model::Exchange> exchanges) {
    model::Instrument made;
    made.every = 1s;
    made.timeout = 100ms;
    made.exchanges = std::move(exchanges);
    return made;
}

/// An engine and its time, moved by hand.
struct Bench {
    explicit Bench(std::vector<model::Exchange> exchanges)
        : settings(instrument(std::move(exchanges))), engine(settings) {
        engine.on_link(now, true);
    }

    std::string asks() {
        const auto sent = engine.transmit(now);
        return {reinterpret_cast<const char*>(sent.data()), sent.size()};
    }
    void pass(Duration time) {
        const Instant end = after(now, time);
        while (engine.next_wakeup() <= end) {
            now = std::max(now, engine.next_wakeup());
            engine.on_tick(now);
            if (const auto sent = asks(); !sent.empty()) {
                asked += sent;
                return;
            }
            if (engine.next_wakeup() <= now) break;
        }
        now = end;
    }
    void receive(std::string_view text) { engine.on_bytes(now, bytes_of(text)); }
    [[nodiscard]] std::string value(std::string_view name) const {
        const auto& reading = engine.reading(name);
        if (!reading.at) return "never";
        if (const auto* const real = std::get_if<double>(&reading.value))
            return std::to_string(*real).substr(0, 4);
        return std::to_string(std::get<std::int64_t>(reading.value)) + (reading.fails ? "?" : "");
    }

    model::Instrument settings;
    InstrumentEngine engine;
    Instant now{std::chrono::hours(1)};
    std::string asked;
};

TEST(Instrument, AsksInTurnAndInItsRhythm) {
    Bench bench({exchange("a\r", "A{a}"), exchange("b\r", "B{b}")});
    EXPECT_EQ(bench.asks(), "a\r");
    const Instant begun = bench.now;
    EXPECT_EQ(bench.asks(), "") << "one question at a time";
    bench.now = after(bench.now, 10ms);
    bench.receive("A1");
    EXPECT_EQ(bench.value("a"), "never");
    bench.receive("2\r");
    EXPECT_EQ(bench.value("a"), "12");
    EXPECT_EQ(*bench.engine.reading("a").at, begun) << "it is as old as its question";
    EXPECT_EQ(bench.asks(), "b\r");
    bench.receive("B3\r");
    EXPECT_EQ(bench.value("b"), "3");
    EXPECT_EQ(bench.asks(), "");
    EXPECT_EQ(bench.engine.next_wakeup(), after(begun, 1s));
    bench.now = after(begun, 1s);
    EXPECT_EQ(bench.asks(), "a\r");
}

TEST(Instrument, AnEchoAndGarbageAreSkipped) {
    Bench bench({exchange("A?\r", "A{a}")});
    EXPECT_EQ(bench.asks(), "A?\r");
    bench.receive("A?\r");
    bench.receive(
        "\xFF\xFE\r"
        "A-------\rA4\rA5\r");
    EXPECT_EQ(bench.value("a"), "4");
    EXPECT_EQ(bench.engine.counters().strange, 3u);
}

// The program was stopped, or busy.
TEST(Instrument, AnAnswerThatIsReadAfterTheTimeOutCounts) {
    Bench bench({exchange("a\r", "{a}")});
    EXPECT_EQ(bench.asks(), "a\r");
    bench.now = after(bench.now, 400ms);
    bench.receive("7\r");
    EXPECT_EQ(bench.value("a"), "7");
    EXPECT_EQ(bench.engine.counters().timeouts, 0u);
    bench.pass(600ms);
    EXPECT_EQ(bench.asked, "a\r");
    bench.now = after(bench.now, 400ms);
    bench.receive("8");
    EXPECT_EQ(bench.engine.counters().timeouts, 1u) << "it is not whole";
}

TEST(Instrument, ALateAnswerBelongsToNoRequest) {
    Bench bench({exchange("a\r", "{a}"), exchange("b\r", "{b}")});
    EXPECT_EQ(bench.asks(), "a\r");
    bench.pass(100ms);
    EXPECT_EQ(bench.engine.counters().timeouts, 1u);
    EXPECT_TRUE(bench.engine.reading("a").fails);
    bench.now = after(bench.now, 90ms);
    bench.receive("7");
    bench.now = after(bench.now, 20ms);
    EXPECT_EQ(bench.asks(), "") << "it is not silent yet";
    bench.receive("7\r");
    bench.pass(200ms);
    EXPECT_EQ(bench.asked, "b\r");
    EXPECT_EQ(bench.value("a"), "never");
    EXPECT_EQ(bench.value("b"), "never");
    bench.receive("8\r");
    EXPECT_EQ(bench.value("b"), "8");
}

TEST(Instrument, OneThatNeverStopsTalkingIsAskedAllTheSame) {
    Bench bench({exchange("a\r", "A{a}")});
    EXPECT_EQ(bench.asks(), "a\r");
    bench.pass(100ms);
    for (int i = 0; i < 300 && bench.asked.empty(); ++i) {
        bench.receive("x");
        bench.pass(10ms);
    }
    EXPECT_EQ(bench.asked, "a\r");
}

TEST(Instrument, TalkingByItselfIsHeardFromTheFirstWholeAnswer) {
    Bench bench({exchange("", "{a} kg"), exchange("", "T{t}")});
    EXPECT_EQ(bench.engine.next_wakeup(), kNever);
    bench.receive("2.5 kg\r");
    EXPECT_EQ(bench.value("a"), "never") << "it may be half of 12.5";
    bench.receive("3.5 kg\rT20\r??\r4.");
    EXPECT_EQ(bench.value("a"), "3.50");
    EXPECT_EQ(bench.value("t"), "20");
    bench.now = after(bench.now, 200ms);
    bench.receive("5 kg\r");
    EXPECT_EQ(bench.value("a"), "5") << "a pause begins anew";
    EXPECT_EQ(bench.engine.reading("t").at, after(bench.now, -200ms));
}

TEST(Instrument, ABrokenLinkForgetsWhatWasHalf) {
    Bench bench({exchange("a\r", "{a}")});
    EXPECT_EQ(bench.asks(), "a\r");
    bench.receive("1");
    bench.engine.on_link(bench.now, false);
    bench.receive("2\r");
    EXPECT_EQ(bench.engine.next_wakeup(), kNever);
    bench.engine.on_link(bench.now, true);
    EXPECT_EQ(bench.asks(), "a\r");
    bench.receive("3\r");
    EXPECT_EQ(bench.value("a"), "3");
}

TEST(Instrument, BinaryTalkIsFoundAmongOtherBytes) {
    model::Exchange talk;
    talk.answer.length = 4;
    talk.answer.begins = "\x02";
    talk.answer.checksum = model::Checksum::exclusive_or;
    talk.answer.fields = {
        {.name = "v", .offset = 1, .bytes = 2, .type = DataType::int16, .order = {true, true}}};
    Bench bench({talk});
    bench.receive({"\x05\x02\x02\x02\x01\x00\x03", 7});
    EXPECT_EQ(bench.value("v"), "256");
    bench.receive({"\x02\x00\x05\x07\x02\x00\x06\x05", 8});
    EXPECT_EQ(bench.value("v"), "5") << "a wrong checksum is no value";
}

RC_GTEST_PROP(Instrument, NoBytesAreTooMany, (const std::vector<std::vector<std::uint8_t>>& pieces)) {
    for (const bool asked : {true, false}) {
        Bench bench({exchange(asked ? "a\r" : "", "A{a}")});
        (void)bench.asks();
        for (const auto& piece : pieces) {
            bench.engine.on_bytes(bench.now, piece);
            bench.engine.on_bytes(bench.now, std::vector<std::uint8_t>(2000, piece.empty() ? 0 : piece[0]));
        }
        RC_ASSERT(bench.value("a") == "never" || bench.engine.counters().answers > 0);
    }
}

}  // namespace instrument_engine_test
}  // namespace takt::endpoint
