#include "takt/sim/answer_faults.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>

namespace takt::sim {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{std::chrono::hours(5)};

TEST(AnswerFaults, Texts) {
    struct Row {
        std::string_view text;
        std::string expected;
    };
    const Row rows[] = {
        {"silence", "silence"},
        {"silence:10%", "silence:10%"},
        {"bad_crc:0.5%", "bad_crc:0.5%"},
        {"delay=50ms..2s", "delay=50ms..2s"},
        {"delay=50ms@10s", "delay=50ms@10s"},
        {"exception=6:100%", "exception=6"},
        {"cut", "cut"},
        {"wrong_unit", "wrong_unit"},
        {"", ""},
        {"delay", ""},
        {"delay=2s..1s", ""},
        {"delay=11min", ""},
        {"delay=1", ""},
        {"exception=0", ""},
        {"exception=256", ""},
        {"exception", ""},
        {"cut=5", ""},
        {"cut:101%", ""},
        {"cut:nan%", ""},
        {"cut:5", ""},
        {"cut@0ms", ""},
        {"cut@", ""},
        {"dog", ""},
    };
    for (const auto& [text, expected] : rows) {
        const auto rule = parse_fault(text);
        EXPECT_EQ(rule ? to_text(*rule) : "", expected) << text;
        if (rule) {
            EXPECT_EQ(parse_fault(to_text(*rule)), rule);
        }
    }
}

std::vector<std::uint8_t> ascii(std::string_view text) {
    return {text.begin(), text.end()};
}

TEST(AnswerFaults, WhatBecomesOfAFrame) {
    using wire::Framing;
    const std::vector<std::uint8_t> rtu{0x10, 0x03, 0x02, 0x00, 0x00, 0x44, 0x47};
    const auto other = damaged({AnswerFault::wrong_unit}, Framing::rtu, rtu);
    EXPECT_EQ(other[0], 0x11);
    EXPECT_EQ(wire::crc16(Bytes(other).first(5)), other[5] | other[6] << 8);
    EXPECT_EQ(damaged({AnswerFault::bad_crc}, Framing::rtu, rtu),
              (std::vector<std::uint8_t>{0x10, 0x03, 0x02, 0x00, 0x00, 0x44, 0xB8}));
    EXPECT_EQ(damaged({AnswerFault::cut}, Framing::rtu, rtu).size(), 4u);
    EXPECT_EQ(damaged({AnswerFault::wrong_unit}, Framing::ascii, ascii(":0F0302FFED\r\n")),
              ascii(":100302FFEC\r\n"));
    EXPECT_EQ(damaged({AnswerFault::bad_crc}, Framing::ascii, ascii(":0F0302FFED\r\n")),
              ascii(":0F0302FF0D\r\n"));
    const std::vector<std::uint8_t> tcp{0, 1, 0, 0, 0, 3, 0xFF, 0x83, 2};
    EXPECT_EQ(damaged({AnswerFault::wrong_unit}, Framing::tcp, tcp)[6], 0);
    EXPECT_EQ(damaged({AnswerFault::bad_crc}, Framing::tcp, tcp), tcp);
}

TEST(AnswerFaults, ByChanceAndBySchedule) {
    AnswerFaults faults(7);
    ASSERT_TRUE(faults.add(kStart, *parse_fault("silence:10%")));
    for (int i = 0; i < 10'000; ++i) (void)faults.strike(kStart, true);
    EXPECT_GT(faults.of(AnswerFault::silence), 850u);
    EXPECT_LT(faults.of(AnswerFault::silence), 1150u);
    faults.clear();
    ASSERT_TRUE(faults.add(kStart, *parse_fault("cut@10s")));
    EXPECT_EQ(faults.strike(kStart, true), nullptr) << "it strikes frames";
    EXPECT_EQ(faults.strike(after(kStart, 9s), false), nullptr);
    EXPECT_NE(faults.strike(after(kStart, 10s), false), nullptr);
    EXPECT_EQ(faults.strike(after(kStart, 10s), false), nullptr);
    EXPECT_NE(faults.strike(after(kStart, 20s), false), nullptr);
    for (std::size_t i = 1; i < AnswerFaults::kMost; ++i) EXPECT_TRUE(faults.add(kStart, {}));
    EXPECT_FALSE(faults.add(kStart, {}));
}

struct Plain final : serve::Responder {
    [[nodiscard]] bool serves(UnitId) const override { return true; }
    [[nodiscard]] serve::Answer handle(const serve::Context&, const wire::RequestView& request) override {
        ++handled;
        wire::Pdu same;
        same.assign(request.pdu());
        return serve::Answer::response(same);
    }
    int handled = 0;
};

TEST(AnswerFaults, Responses) {
    Plain plain;
    AnswerFaults faults;
    const std::uint8_t pdu[] = {3, 0, 0, 0, 1};
    const wire::RequestView request(pdu);
    const auto handle = [&](const serve::Context& context) {
        return with_faults(faults, context, request, [&] { return plain.handle(context, request); });
    };
    faults.add(kStart, *parse_fault("exception=6"));
    const auto refused = handle({.time = kStart});
    EXPECT_EQ(refused.pdu[0], 0x83);
    EXPECT_EQ(refused.pdu[1], 6);
    EXPECT_EQ(plain.handled, 0);
    faults.clear();
    faults.add(kStart, *parse_fault("delay=20ms"));
    EXPECT_EQ(handle({.time = kStart}).delay, Duration(20ms));
    faults.clear();
    faults.add(kStart, *parse_fault("silence"));
    EXPECT_EQ(handle({.time = kStart}).kind, serve::Answer::Kind::silence);
    EXPECT_EQ(plain.handled, 2);
    (void)handle({.time = kStart, .broadcast = true});
    EXPECT_EQ(faults.of(AnswerFault::silence), 1u) << "a broadcast has no answer";
}

RC_GTEST_PROP(AnswerFaults, AnyTextAndAnyFrame,
              (const std::string& text, const std::vector<std::uint8_t>& frame)) {
    (void)parse_fault(text);
    for (const auto kind : {AnswerFault::bad_crc, AnswerFault::wrong_unit, AnswerFault::cut})
        for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii, wire::Framing::tcp})
            RC_ASSERT(damaged({kind}, framing, frame).size() <= frame.size());
}

}  // namespace
}  // namespace takt::sim
