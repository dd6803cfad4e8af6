#include "serial_rig.hpp"

namespace takt::serve {
namespace serial_slave_ascii_test {

std::string ascii(std::string_view text) {
    return hex(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

// 44-47
TEST(SerialSlave, Ascii) {
    struct Row {
        const char* what;
        std::string input;
        bool answered;
        wire::FrameFault fault;
    };
    const Row kRows[] = {
        {"good", ":010300100002EA\r\n", true, wire::FrameFault::none},
        {"lower case", ":010300100002ea\r\n", true, wire::FrameFault::none},
        {"':' inside a frame", ":0103001:010300100002EA\r\n", true, wire::FrameFault::none},
        {"noise before", "\r\nzz\n:010300100002EA\r\n", true, wire::FrameFault::none},
        {"odd digits", ":01030010002EA\r\n", false, wire::FrameFault::bad_character},
        {"no digit", ":0103G0100002EA\r\n", false, wire::FrameFault::bad_character},
        {"bad LRC", ":010300100002EB\r\n", false, wire::FrameFault::checksum},
        {"CR without LF", ":010300100002EA\r:", false, wire::FrameFault::bad_character},
        {"over 513 characters", ":" + std::string(600, '0') + "\r\n", false, wire::FrameFault::too_long},
        {"broadcast read", ":000300100002EB\r\n", false, wire::FrameFault::none},
    };
    const std::string good = ascii(":010300100002EA\r\n");
    const std::string answer = frame(wire::Framing::ascii, 1, "03 04 0010 0011");
    for (const auto& [what, input, answered, fault] : kRows) {
        Rig rig(ascii_config());
        EXPECT_EQ(rig.exchange(ascii(input)), answered ? answer : "") << what;
        EXPECT_TRUE(fault == wire::FrameFault::none || rig.slave.counters().of(fault) >= 1) << what;
        rig.run(2s);
        EXPECT_EQ(rig.exchange(good), answer) << "after " << what;
    }
}

TEST(SerialSlave, AsciiPauseOverASecondDropsTheFrame) {
    for (const Duration pause : {900ms, 1100ms}) {
        Rig rig(ascii_config());
        rig.receive(ascii(":01030010"));
        rig.run(pause);
        rig.receive(ascii("0002EA\r\n"));
        rig.run(100ms);
        EXPECT_EQ(rig.sent.empty(), pause > 1s);
    }
}

TEST(SerialSlave, AsciiTimeouts) {
    struct Row {
        Duration byte_timeout, frame_timeout, pace;
        wire::FrameFault fault;
    };
    using enum wire::FrameFault;
    constexpr Row kRows[] = {{0ms, 0ms, 900ms, none},
                             {0ms, 5s, 900ms, too_slow},
                             {2s, 0ms, 1500ms, none},
                             {100ms, 0ms, 900ms, pause}};
    for (const auto& [byte_timeout, frame_timeout, pace, fault] : kRows) {
        SerialConfig config = ascii_config();
        config.byte_timeout = byte_timeout;
        config.frame_timeout = frame_timeout;
        Rig rig(config);
        const std::string request = ascii(":010300100002EA\r\n");
        for (const std::uint8_t character : bytes(request)) {
            rig.slave.on_bytes(rig.now, Bytes(&character, 1));
            rig.run(pace);
        }
        EXPECT_EQ(rig.sent.empty(), fault != none) << wire::name(fault);
        EXPECT_EQ(rig.slave.counters().of(fault), fault == none ? 0u : 1u) << wire::name(fault);
    }
}

TEST(SerialSlave, AsciiWithoutTurnaroundAnswersAtOnce) {
    Rig rig(ascii_config());
    rig.receive(ascii(":010300100002EA\r\n"));
    EXPECT_EQ(rig.sent, frame(wire::Framing::ascii, 1, "03 04 0010 0011"));
}

}  // namespace serial_slave_ascii_test
}  // namespace takt::serve
