#include "takt/firmware/serial_device.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "board_model.hpp"
#include "takt/firmware/slave_frame.hpp"
#include "takt/serve/diagnostics.hpp"
#include "takt/wire/frame.hpp"

namespace takt::firmware {
namespace serial_device_test {

using Frame = std::vector<std::uint8_t>;
using model::board;

constexpr wire::CharacterFormat k9600{.baud = 9600, .parity = wire::Parity::none};
constexpr std::uint32_t kCharacter = 1'041;   // 10 bits
constexpr std::uint32_t kHalfLonger = 1'562;  // t1.5
constexpr std::uint32_t kEnd = 3'645;         // t3.5

Frame frame(wire::Framing framing, std::uint8_t unit, const Frame& pdu) {
    const auto bytes = wire::encode_frame(framing, UnitId{unit}, 0, pdu);
    return {bytes.begin(), bytes.end()};
}

struct Rig {
    explicit Rig(wire::Framing its = wire::Framing::rtu, bool strict = false)
        : framing(its), device({.framing = its, .format = k9600, .strict = strict}, server) {
        board = {};
        EXPECT_TRUE(device.start());
        board.pass(10'000);
    }

    // The first character ends after `gap`, the others follow back to back.
    void send(const Frame& bytes, std::uint32_t gap = 20'000) {
        for (const auto byte : bytes) {
            board.pass(std::exchange(gap, kCharacter));
            board.receive(byte);
        }
    }
    Frame response() {
        board.sent.clear();
        board.pass(kEnd + kCharacter + 1);
        while (device.work()) {}
        board.pass(2'000'000);
        return std::exchange(board.sent, {});
    }
    Frame ask(const Frame& request) {
        send(request);
        return response();
    }
    Frame of(const Frame& pdu) const { return frame(framing, 1, pdu); }
    unsigned errors() {
        const Frame answer = ask(of({8, 0, 12, 0, 0}));
        return answer.empty() ? 999U : framing == wire::Framing::rtu ? answer.at(5) : answer.at(12) - '0';
    }

    wire::Framing framing;
    BankStorage<16, 16, 8, 125> storage;
    serve::Diagnostics diagnostics;
    serve::Extension* extensions[1]{&diagnostics};
    serve::Unit units[1]{{UnitId{1}, storage.banks(), nullptr, extensions}};
    serve::Server server{units};
    SerialDevice device;
};

TEST(SerialDevice, AnswersInBothFramings) {
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii}) {
        Rig rig(framing);
        rig.storage.holding_registers[1] = 0xAB34;
        EXPECT_EQ(rig.ask(rig.of({3, 0, 1, 0, 1})), rig.of({3, 2, 0xAB, 0x34}));
        EXPECT_EQ(rig.ask(rig.of({6, 0, 2, 0, 9})), rig.of({6, 0, 2, 0, 9}));
        EXPECT_EQ(rig.storage.holding_registers[2], 9);
        EXPECT_EQ(rig.ask(rig.of({3, 0, 0, 0, 125})).size(), framing == wire::Framing::rtu ? 255U : 511U);
        EXPECT_EQ(rig.ask(frame(framing, 2, {3, 0, 1, 0, 1})), Frame{});
        EXPECT_EQ(rig.ask(frame(framing, 0, {6, 0, 3, 0, 7})), Frame{});
        EXPECT_EQ(rig.storage.holding_registers[3], 7) << "a broadcast is executed";
        EXPECT_EQ(rig.errors(), 0U);
    }
}

TEST(SerialDevice, TheDriverIsOnFromBeforeTheFirstCharacterToAfterTheLast) {
    Rig rig;
    rig.send(rig.of({3, 0, 0, 0, 1}));
    board.pass(kEnd + kCharacter + 1);
    ASSERT_TRUE(rig.device.work());
    board.pass(6 * board.character_time);
    EXPECT_EQ(board.log, "+sssssss") << "the last of 7 is on the line";
    board.pass(board.character_time);
    EXPECT_EQ(board.log, "+sssssss-");
}

TEST(SerialDevice, ARequestEndsAfterItsSilenceOnly) {
    Rig rig;
    rig.send(rig.of({3, 0, 0, 0, 1}));
    board.pass(kEnd + kCharacter - 1);
    EXPECT_FALSE(rig.device.work()) << "a character that began within t3.5 may still end";
    board.pass(2);
    EXPECT_TRUE(rig.device.work());
}

// Gaps from the end of a character to that of the next one, in a frame.
TEST(SerialDevice, JudgesPausesInsideAFrame) {
    struct Case {
        bool strict;
        std::uint32_t silence;
        bool answered;
        unsigned errors;
    };
    for (const Case& its : {Case{true, kHalfLonger - 10, true, 0}, Case{true, kHalfLonger + 10, false, 1},
                            Case{true, kEnd - 10, false, 1}, Case{true, kEnd + 10, false, 2},
                            Case{false, kHalfLonger + 10, true, 0}, Case{false, kEnd - 10, true, 0},
                            Case{false, kEnd + 10, false, 2}}) {
        Rig rig(wire::Framing::rtu, its.strict);
        const Frame request = rig.of({3, 0, 0, 0, 1});
        rig.send({request.begin(), request.begin() + 4});
        board.pass(its.silence + kCharacter);
        for (std::size_t i = 4; i < request.size(); ++i) {
            if (i > 4) board.pass(kCharacter);
            rig.device.work();
            board.receive(request[i]);
        }
        EXPECT_EQ(!rig.response().empty(), its.answered) << its.strict << ' ' << its.silence;
        EXPECT_EQ(rig.errors(), its.errors) << its.strict << ' ' << its.silence;
    }
}

TEST(SerialDevice, ARequestMayFollowAtOnceUnlessStrict) {
    for (const bool strict : {false, true}) {
        Rig rig(wire::Framing::rtu, strict);
        rig.send(rig.of({3, 0, 0, 0, 1}));
        board.pass(kEnd + kCharacter + 1);
        ASSERT_TRUE(rig.device.work());
        board.pass(7 * board.character_time);
        rig.send(rig.of({3, 0, 0, 0, 2}), kCharacter);
        EXPECT_EQ(rig.response().empty(), strict);
        EXPECT_EQ(rig.ask(rig.of({3, 0, 0, 0, 2})).size(), 9U);
    }
}

TEST(SerialDevice, IgnoresWhatComesUntilItHasAnswered) {
    Rig rig;
    rig.send(rig.of({3, 0, 0, 0, 1}));
    board.pass(kEnd + kCharacter + 1);
    board.receive(7);
    ASSERT_TRUE(rig.device.work());
    for (int i = 0; i < 7; ++i) {
        board.receive(board.sent.back());  // the own echo
        board.pass(board.character_time);
    }
    EXPECT_EQ(board.sent, rig.of({3, 2, 0, 0}));
    EXPECT_EQ(rig.errors(), 0U);
}

TEST(SerialDevice, DropsADamagedFrame) {
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii}) {
        Rig rig(framing);
        const Frame request = rig.of({3, 0, 0, 0, 1});
        for (std::size_t damaged = 0; damaged < request.size(); ++damaged) {
            for (std::size_t i = 0; i < request.size(); ++i) {
                board.pass(i == 0 ? 20'000 : kCharacter);
                board.receive(request[i], i == damaged);
            }
            EXPECT_EQ(rig.response(), Frame{}) << damaged;
        }
        EXPECT_EQ(rig.ask(request), rig.of({3, 2, 0, 0}));
    }
}

TEST(SerialDevice, ALongFrameIsOneError) {
    Rig rig;
    rig.send(Frame(300, 1));
    EXPECT_EQ(rig.response(), Frame{});
    EXPECT_EQ(rig.errors(), 1U);
}

TEST(SerialDevice, AnAsciiFrameBeginsAtAColonAndEndsWithItsLineFeed) {
    const auto text = [](std::string_view characters) { return Frame(characters.begin(), characters.end()); };
    const std::string good = ":010300000001FB\r\n";
    struct Case {
        std::string sent;
        unsigned answers;
        unsigned errors;
    };
    for (const Case& its : {Case{good, 1, 0}, Case{"noise" + good, 1, 0}, Case{":0103" + good, 1, 1},
                            Case{":010300000001FA\r\n", 0, 1}, Case{":01030000000FB\r\n", 0, 1},
                            Case{":010300000001fb\r\n", 0, 1}, Case{":010300000001FB\n", 0, 1},
                            Case{":010300000001FB\r\r\n", 0, 1}, Case{":010300000001FB\rX\n", 0, 1},
                            Case{":\r\n", 0, 1}, Case{":" + std::string(600, '0') + "\r\n", 0, 1}}) {
        Rig rig(wire::Framing::ascii);
        EXPECT_EQ(rig.ask(text(its.sent)).empty(), its.answers == 0) << its.sent;
        EXPECT_EQ(rig.errors(), its.errors) << its.sent;
    }
}

TEST(SerialDevice, AnAsciiFrameMayPauseForASecond) {
    for (const std::uint32_t pause : {999'000U, 1'003'000U}) {
        Rig rig(wire::Framing::ascii);
        const Frame request = rig.of({3, 0, 0, 0, 1});
        rig.send({request.begin(), request.begin() + 5});
        rig.send({request.begin() + 5, request.end()}, pause);
        EXPECT_EQ(rig.response().empty(), pause > 1'000'000) << pause;
    }
}

TEST(SerialDevice, TheBoardMayHaveNoSuchFormat) {
    BankStorage<8, 8, 8, 8> storage;
    serve::Unit units[1]{{UnitId{1}, storage.banks()}};
    serve::Server server(units);
    board = {};
    SerialDevice device({.format = {.stop_bits = 2}}, server);
    EXPECT_FALSE(device.start());
}

// The device answers after any bytes with any pauses.
RC_GTEST_PROP(SerialDevice, AnswersAfterAnyNoise, ()) {
    const auto framing = *rc::gen::element(wire::Framing::rtu, wire::Framing::ascii);
    Rig rig(framing, *rc::gen::arbitrary<bool>());
    const auto noise = *rc::gen::container<Frame>(rc::gen::arbitrary<std::uint8_t>());
    for (const auto byte : noise) {
        board.pass(*rc::gen::inRange(0U, 2 * kEnd));
        board.receive(byte, *rc::gen::inRange(0, 20) == 0);
        if (*rc::gen::arbitrary<bool>()) rig.device.work();
    }
    rig.response();
    RC_ASSERT(rig.ask(rig.of({3, 0, 0, 0, 1})).size() == rig.of({3, 2, 0, 0}).size());
}

}  // namespace serial_device_test
}  // namespace takt::firmware
