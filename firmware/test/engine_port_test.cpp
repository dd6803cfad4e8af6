#include "takt/firmware/engine_port.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "board_model.hpp"

namespace takt::firmware {
namespace engine_port_test {

using model::board;
using Frame = std::vector<std::uint8_t>;

constexpr wire::CharacterFormat k9600{.baud = 9600, .parity = wire::Parity::none};

// Notes the calls with their times in microseconds: "B 100 3", "K 200".
class Recorder final : public Engine {
public:
    void on_link(Instant t, bool up) override { note(t, up ? "up" : "down"); }
    void on_bytes(Instant t, Bytes bytes) override {
        received.insert(received.end(), bytes.begin(), bytes.end());
        note(t, "bytes");
    }
    void on_tick(Instant t) override {
        wakeup = kNever;
        note(t, "tick");
    }
    Bytes transmit(Instant t) override {
        EXPECT_GE(t, last);
        shown = std::exchange(to_send, {});
        return shown;
    }
    Instant next_wakeup() const override { return wakeup; }

    void note(Instant t, const char* what) {
        EXPECT_GE(t, last) << what;
        last = t;
        calls += std::string(what) + ' ' +
                 std::to_string(t.time_since_epoch() / std::chrono::microseconds(1)) + ' ';
    }

    Instant last;
    Instant wakeup = kNever;
    Frame received, to_send, shown;
    std::string calls;
};

struct Rig {
    Rig() {
        board = {};
        EXPECT_TRUE(port.start(k9600));
        work();
        recorder.calls.clear();
    }
    void work() {
        while (port.work()) {}
    }
    void pass(std::uint32_t microseconds) {
        for (std::uint32_t i = 0; i < microseconds; ++i) {
            board.pass(1);
            work();
        }
    }
    Recorder recorder;
    EnginePort port{recorder};
};

TEST(EnginePort, GivesReceivedCharactersWithTheirTime) {
    Rig rig;
    board.pass(100);
    board.receive(1);
    board.pass(50);
    board.receive(2);
    board.pass(7);
    rig.work();
    EXPECT_EQ(rig.recorder.received, (Frame{1, 2}));
    EXPECT_EQ(rig.recorder.calls, "bytes 150 ");
}

TEST(EnginePort, WakesTheEngineWhenItAsks) {
    Rig rig;
    rig.recorder.wakeup = Instant{} + std::chrono::nanoseconds(300'500);
    board.receive(1);
    rig.pass(400);
    EXPECT_EQ(rig.recorder.calls, "bytes 0 tick 301 ");
}

TEST(EnginePort, SendsWithTheDriverOn) {
    Rig rig;
    rig.recorder.to_send = {7, 8, 9};
    board.receive(1);
    rig.work();
    EXPECT_EQ(board.log, "+s");
    rig.recorder.to_send = {10};
    board.receive(2);
    rig.work();
    EXPECT_EQ(board.log, "+s") << "one frame at a time";
    board.pass(3 * board.character_time);
    EXPECT_EQ(board.log, "+sss-");
    rig.work();
    EXPECT_EQ(board.log, "+sss-+s");
    EXPECT_EQ(board.sent, (Frame{7, 8, 9, 10}));
}

TEST(EnginePort, LosesCharactersOnlyWhenTheRingIsFull) {
    Rig rig;
    Frame all;
    for (std::size_t i = 0; i < EnginePort::kMostWaiting + 5; ++i) {
        all.push_back(static_cast<std::uint8_t>(i));
        board.receive(all.back());
    }
    rig.work();
    all.resize(EnginePort::kMostWaiting);
    EXPECT_EQ(rig.recorder.received, all);
    board.receive(77);
    rig.work();
    EXPECT_EQ(rig.recorder.received.back(), 77);
}

// The board's clock wraps around after 71 minutes.
TEST(EnginePort, TheTimeOfTheEngineGoesOnWhereTheClockWrapsAround) {
    Rig rig;
    for (int minute = 0; minute < 200; ++minute) {
        board.pass(60'000'000);
        rig.work();
    }
    board.receive(1);
    rig.work();
    EXPECT_EQ(rig.recorder.calls, "bytes 12000000000 ");
}

}  // namespace engine_port_test
}  // namespace takt::firmware
