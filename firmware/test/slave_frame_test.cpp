#include "takt/firmware/slave_frame.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>
#include <vector>

#include "takt/serve/diagnostics.hpp"
#include "takt/wire/frame.hpp"

namespace takt::firmware {
namespace slave_frame_test {

using Frame = std::vector<std::uint8_t>;

Frame frame(std::uint8_t unit, const Frame& pdu) {
    const auto bytes = wire::encode_frame(wire::Framing::rtu, UnitId{unit}, 0, pdu);
    return {bytes.begin(), bytes.end()};
}

struct Rig {
    Frame ask(const Frame& request) {
        Frame buffer(wire::kMaxRtuFrame);
        buffer.resize(respond_rtu(server, request, buffer));
        return buffer;
    }
    BankStorage<20, 16, 8, 300> storage;
    serve::Diagnostics diagnostics{{false, true, {}}};
    serve::Extension* extensions[1]{&diagnostics};
    serve::Unit units[1]{{UnitId{17}, storage.banks(), nullptr, extensions}};
    serve::Server server{units};
};

TEST(SlaveFrame, AnswersAFrameWithAFrame) {
    Rig rig;
    rig.storage.input_registers[1] = 0x1234;
    EXPECT_EQ(rig.ask(frame(17, {4, 0, 1, 0, 1})), frame(17, {4, 2, 0x12, 0x34}));
    EXPECT_EQ(rig.ask(frame(17, {6, 1, 0x2B, 0, 7})), frame(17, {6, 1, 0x2B, 0, 7}));
    EXPECT_EQ(rig.storage.holding_registers[299], 7);
    EXPECT_EQ(rig.ask(frame(17, {6, 1, 0x2C, 0, 7})), frame(17, {0x86, 2}));
    EXPECT_EQ(rig.ask(frame(17, {1, 0, 19, 0, 1})), frame(17, {1, 1, 0}));
    EXPECT_EQ(rig.ask(frame(17, {1, 0, 20, 0, 1})), frame(17, {0x81, 2}));
    EXPECT_EQ(rig.ask(frame(17, {0x41})), frame(17, {0xC1, 1}));
    EXPECT_EQ(rig.ask(frame(17, {3, 0, 0, 0, 125})).size(), 255u);
}

TEST(SlaveFrame, TheAnswerMayTakeTheRoomOfTheRequest) {
    Rig rig;
    for (const Frame& pdu :
         {Frame{3, 0, 0, 0, 125}, Frame{6, 0, 3, 0xAB, 0xCD},
          Frame{0x17, 0, 3, 0, 2, 0, 4, 0, 2, 4, 1, 2, 3, 4}, Frame{0x0F, 0, 0, 0, 9, 2, 0xFF, 1}}) {
        const Frame request = frame(17, pdu);
        const Frame expected = rig.ask(request);
        Frame buffer = request;
        buffer.resize(wire::kMaxRtuFrame);
        buffer.resize(respond_rtu(rig.server, Bytes(buffer).first(request.size()), buffer));
        EXPECT_EQ(buffer, expected);
    }
}

TEST(SlaveFrame, SaysNothingWhereNothingIsToBeSaid) {
    Rig rig;
    const Frame read = frame(17, {3, 0, 0, 0, 1});
    Frame bad = read;
    bad.back() ^= 1;
    EXPECT_EQ(rig.ask(bad), Frame{});
    EXPECT_EQ(rig.ask({}), Frame{});
    EXPECT_EQ(rig.ask({17}), Frame{});
    EXPECT_EQ(rig.ask({0, 0}), Frame{}) << "a CRC of nothing";
    EXPECT_EQ(rig.ask(frame(18, {3, 0, 0, 0, 1})), Frame{});
    EXPECT_EQ(rig.ask(frame(0, {6, 0, 2, 0, 9})), Frame{});
    EXPECT_EQ(rig.storage.holding_registers[2], 9) << "a broadcast is done";
    Frame large = frame(17, Frame(253, 3));
    large.push_back(0);
    EXPECT_EQ(rig.ask(large), Frame{});
    EXPECT_EQ(rig.ask(frame(17, {8, 0, 12, 0, 0})), frame(17, {8, 0, 12, 0, 5})) << "bad frames are counted";
    EXPECT_EQ(rig.ask(frame(17, {8, 0, 4, 0, 0})), Frame{});
    EXPECT_EQ(rig.ask(read), Frame{}) << "listen-only mode";
}

RC_GTEST_PROP(SlaveFrame, AnyFrameGetsAFrameOrNothing, ()) {
    Rig rig;
    auto pdu = *rc::gen::resize(60, rc::gen::nonEmpty(rc::gen::arbitrary<Frame>()));
    if (*rc::gen::inRange(0, 4) != 0) pdu[0] = *rc::gen::inRange<std::uint8_t>(1, 25);
    Frame request = frame(17, pdu);
    request.shrink_to_fit();
    const Frame answer = rig.ask(request);
    if (answer.empty()) return;
    RC_ASSERT(answer.size() >= 5u);
    RC_ASSERT(wire::crc16(answer) == 0);
    RC_ASSERT(answer[0] == 17);
    RC_ASSERT((answer[1] & 0x7F) == (pdu[0] & 0x7F));
}

}  // namespace slave_frame_test
}  // namespace takt::firmware
