#include "takt/sim/answer_faults.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace takt::sim {
namespace answer_faults_test {

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

/// Sends one transmission.
class Sender final : public Engine {
public:
    explicit Sender(std::vector<std::uint8_t> bytes) : bytes_(std::move(bytes)) {}
    void on_link(Instant, bool) override {}
    void on_bytes(Instant, Bytes) override {}
    void on_tick(Instant) override {}
    Bytes transmit(Instant) override { return bytes_; }
    [[nodiscard]] Instant next_wakeup() const override { return kNever; }

private:
    std::vector<std::uint8_t> bytes_;
};

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

FaultRule scoped(std::string_view fault, FaultScope scope) {
    auto rule = *parse_fault(fault);
    rule.scope = std::move(scope);
    return rule;
}

TEST(AnswerFaults, AreOfOneDeviceOrOfSomeOfItsItems) {
    AnswerFaults faults;
    faults.add(kStart, scoped("silence", {"Meter", "A", UnitId{1}, std::nullopt}));
    faults.add(kStart, scoped("exception=4",
                              {"P", "A", UnitId{2}, FaultScope::Items{wire::Area::holding_register, 10, 2}}));
    const auto kind = [&](std::string_view line, std::uint8_t unit, std::vector<wire::ItemAccess> accesses) {
        const auto* rule = faults.strike(kStart, true, {line, UnitId{unit}, accesses});
        return rule ? to_text(*rule) : std::string("none");
    };
    constexpr auto kHolding = wire::Area::holding_register;
    EXPECT_EQ(kind("A", 1, {}), "silence");
    EXPECT_EQ(kind("B", 1, {}), "none");
    EXPECT_EQ(kind("A", 2, {{kHolding, false, 0, 10}}), "none");
    EXPECT_EQ(kind("A", 2, {{kHolding, false, 0, 11}}), "exception=4");
    EXPECT_EQ(kind("A", 2, {{kHolding, false, 11, 1}}), "exception=4");
    EXPECT_EQ(kind("A", 2, {{kHolding, false, 12, 5}}), "none");
    EXPECT_EQ(kind("A", 2, {{wire::Area::input_register, false, 10, 2}}), "none");
    EXPECT_EQ(kind("A", 2, {{kHolding, false, 0, 1}, {kHolding, true, 10, 1}}), "exception=4") << "0x17";
    EXPECT_EQ(kind("", 0, {}), "none");
    EXPECT_EQ(faults.clear("Meter"), 1U);
    EXPECT_EQ(faults.clear("Meter"), 0U);
    EXPECT_EQ(faults.rules().size(), 1U);
}

TEST(AnswerFaults, TheUnitsOfAHostMeanItsFirstDevice) {
    const FaultSite site{"A", {UnitId{7}, UnitId{255}}};
    EXPECT_EQ(site.device_of(UnitId{0}), UnitId{7});
    EXPECT_EQ(site.device_of(UnitId{255}), UnitId{255}) << "a device of its own";
    EXPECT_EQ(site.device_of(UnitId{9}), UnitId{9});
    EXPECT_EQ(FaultSite{}.device_of(UnitId{255}), UnitId{255});
}

TEST(AnswerFaults, DamageTheFramesOfOneDevice) {
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii, wire::Framing::tcp}) {
        AnswerFaults faults;
        faults.add(kStart, scoped("wrong_unit", {"Meter", "A", UnitId{0x1B}, std::nullopt}));
        const std::uint8_t pdu[] = {3, 2, 0, 7};
        for (const auto unit : {std::uint8_t{0x1A}, std::uint8_t{0x1B}}) {
            const auto frame = wire::encode_frame(framing, UnitId{unit}, 5, pdu);
            const auto wrong = wire::encode_frame(framing, UnitId{0x1C}, 5, pdu);
            Sender sender({frame.begin(), frame.end()});
            FaultyEngine engine(sender, framing, faults, {"A", {UnitId{0x1B}}});
            const Bytes sent = engine.transmit(kStart);
            const auto& wanted = unit == 0x1B ? wrong : frame;
            EXPECT_TRUE(std::ranges::equal(sent, wanted)) << static_cast<int>(framing) << ' ' << int{unit};
        }
    }
}

TEST(AnswerFaults, Responses) {
    Plain plain;
    AnswerFaults faults;
    const std::uint8_t pdu[] = {3, 0, 0, 0, 1};
    const wire::RequestView request(pdu);
    const auto handle = [&](const serve::Context& context) {
        return with_faults(faults, {}, context, request, [&] { return plain.handle(context, request); });
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

}  // namespace answer_faults_test
}  // namespace takt::sim
