#include "byte_stream.hpp"

#include <gtest/gtest.h>

#include "support.hpp"
#include "takt/sim/devices.hpp"
#include "takt/wire/frame.hpp"

namespace takt::sim {
namespace byte_stream_test {

using namespace std::chrono_literals;

ByteVector request(std::uint16_t transaction, const wire::Pdu& pdu) {
    const auto frame = wire::encode_frame(wire::Framing::tcp, UnitId{1}, transaction, pdu.span());
    return {frame.begin(), frame.end()};
}

struct Rig {
    explicit Rig(const serve::TcpConfig& config = {})
        : server(config, devices), stream(client, server, {1ms, 10ns}) {
        stream.set_observer(&record);
        stream.set_link(Instant{}, true);
    }
    Devices devices{UnitId{1}, Fill::ramp};
    Talker client;
    serve::TcpConnection server;
    ByteStream stream;
    Record record;
};

TEST(ByteStream, TakesItsTimeEachWay) {
    Rig rig;
    rig.devices[0].behaviour.turnaround = 3ms;
    rig.client.send(at(0ms), request(7, {0x03, 0x12, 0x34, 0x00, 0x01}));
    rig.stream.run_until(at(50ms));
    ASSERT_EQ(rig.client.received.size(), 1u);
    EXPECT_EQ(rig.client.all, request(7, {0x03, 0x02, 0x12, 0x34}));
    EXPECT_EQ(rig.client.received[0].first, at(5ms + (12 + 11) * 10ns));
    ASSERT_EQ(rig.record.entries.size(), 2u);
    EXPECT_EQ(rig.record.entries[0].sender, 0u);
    EXPECT_EQ(rig.record.entries[1].start, at(4ms + 120ns));
}

TEST(ByteStream, LetsTheClientWaitForTheServer) {
    Rig rig;
    rig.devices[0].behaviour.turnaround = 1ms;
    ByteVector many;
    for (std::uint16_t i = 0; i < 300; ++i) {
        const ByteVector one = request(i, {0x03, 0x00, 0x00, 0x00, 0x01});
        many.insert(many.end(), one.begin(), one.end());
    }
    rig.client.send(at(0ms), many);
    rig.stream.run_until(at(10s));
    EXPECT_EQ(rig.client.all.size(), 300u * 11);
    EXPECT_EQ(rig.server.close_reason(), serve::CloseReason::none);
}

TEST(ByteStream, TheServerMayEndIt) {
    Rig rig;
    rig.client.send(at(0ms), {'G', 'E', 'T', ' ', '/', ' ', 'H', 'T'});
    rig.stream.run_until(at(50ms));
    EXPECT_FALSE(rig.client.up);
    EXPECT_EQ(rig.stream.next_wakeup(), kNever);
    rig.stream.set_link(at(60ms), true);
    EXPECT_TRUE(rig.client.up);
    EXPECT_EQ(rig.server.close_reason(), serve::CloseReason::none);
}

}  // namespace byte_stream_test
}  // namespace takt::sim
