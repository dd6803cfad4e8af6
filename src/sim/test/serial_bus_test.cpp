#include "serial_bus.hpp"

#include <gtest/gtest.h>

#include "support.hpp"

namespace takt::sim {
namespace serial_bus_test {

using namespace std::chrono_literals;

constexpr wire::CharacterFormat kFormat{10000, 8, wire::Parity::none, 1};  // one character: 1 ms

struct Rig {
    explicit Rig(SerialBus::Options options = {}, bool echo = false) : bus(kFormat, options) {
        bus.attach(a, echo);
        bus.attach(b);
        bus.attach(c);
        bus.set_observer(&record);
    }
    void run(Duration until) {
        bus.set_link(Instant{}, true);
        bus.run_until(at(until));
    }
    SerialBus bus;
    Talker a, b, c;
    Record record;
};

TEST(SerialBus, EachCharacterArrivesAtItsEnd) {
    Rig rig;
    rig.a.send(at(5ms), {1, 2, 3});
    rig.run(100ms);
    const std::vector<std::pair<Instant, ByteVector>> expected{
        {at(6ms), {1}}, {at(7ms), {2}}, {at(8ms), {3}}};
    EXPECT_EQ(rig.b.received, expected);
    EXPECT_EQ(rig.c.received, expected);
    EXPECT_TRUE(rig.a.received.empty());
    EXPECT_EQ(rig.record.entries, (std::vector<Record::Entry>{{0, at(5ms), at(8ms), {1, 2, 3}, false}}));
}

TEST(SerialBus, ChunksAndWholeTransmissions) {
    Rig chunks({.chunk = 2});
    chunks.a.send(at(5ms), {1, 2, 3});
    chunks.run(100ms);
    EXPECT_EQ(chunks.b.received,
              (std::vector<std::pair<Instant, ByteVector>>{{at(7ms), {1, 2}}, {at(8ms), {3}}}));
    Rig whole({.chunk = 0});
    whole.a.send(at(5ms), {1, 2, 3});
    whole.run(100ms);
    EXPECT_EQ(whole.b.received, (std::vector<std::pair<Instant, ByteVector>>{{at(8ms), {1, 2, 3}}}));
}

TEST(SerialBus, WithoutAnAdapterWholeTransmissionsAreReceived) {
    SerialBus bus(kFormat, {.chunk = 2});
    Talker a, b, c;
    bus.attach(a);
    bus.attach(b);
    bus.attach(c, false, false);
    a.send(at(5ms), {1, 2, 3});
    bus.set_link(Instant{}, true);
    bus.run_until(at(100ms));
    EXPECT_EQ(b.received, (std::vector<std::pair<Instant, ByteVector>>{{at(7ms), {1, 2}}, {at(8ms), {3}}}));
    EXPECT_EQ(c.received, (std::vector<std::pair<Instant, ByteVector>>{{at(8ms), {1, 2, 3}}}));
}

TEST(SerialBus, EchoWhereAskedFor) {
    Rig rig({}, true);
    rig.a.send(at(0ms), {1, 2});
    rig.b.send(at(9ms), {3});
    rig.run(100ms);
    EXPECT_EQ(rig.a.all, (ByteVector{1, 2, 3}));
    EXPECT_EQ(rig.b.all, (ByteVector{1, 2}));
}

TEST(SerialBus, OverlappingCharactersAreSpoiledTheOthersNot) {
    Rig rig;
    rig.a.send(at(0ms), {1, 2, 3, 4});
    rig.b.send(at(2500us), {5, 6, 7});
    rig.run(100ms);
    ASSERT_EQ(rig.c.all.size(), 7u);
    // In the order of their ends: a at 1, 2, 3 and 4 ms, b at 3.5, 4.5 and 5.5 ms; a ends within b's second
    // character.
    const ByteVector sent{1, 2, 3, 5, 4, 6, 7};
    const std::vector<bool> good{true, true, false, false, false, false, true};
    for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(rig.c.all[i] == sent[i], good[i]) << i;
    EXPECT_EQ(rig.b.all, (ByteVector{1, 2})) << "a sender does not receive";
    ASSERT_EQ(rig.record.entries.size(), 2u);
    EXPECT_TRUE(rig.record.entries[0].collided);
    EXPECT_TRUE(rig.record.entries[1].collided);
}

TEST(SerialBus, BackToBackIsNoCollision) {
    Rig rig;
    rig.a.send(at(0ms), {1, 2});
    rig.b.send(at(2ms), {3});
    rig.a.send(at(2500us), {4});  // begins within b's: after all a collision of these two
    rig.run(100ms);
    EXPECT_FALSE(rig.record.entries[0].collided);
    EXPECT_TRUE(rig.record.entries[1].collided);
}

TEST(SerialBus, BytesGivenWhileSendingFollow) {
    Rig rig;
    rig.a.send(at(0ms), {1, 2});
    rig.a.send(at(1500us), {3});
    rig.run(100ms);
    EXPECT_EQ(rig.record.entries, (std::vector<Record::Entry>{{0, at(0ms), at(3ms), {1, 2, 3}, false}}));
}

TEST(SerialBus, ALostLinkLosesWhatIsOnTheWay) {
    Rig rig;
    rig.a.send(at(0ms), {1, 2, 3});
    rig.run(1ms);
    EXPECT_TRUE(rig.b.up);
    rig.bus.set_link(at(2ms), false);
    EXPECT_FALSE(rig.b.up);
    rig.bus.run_until(at(50ms));
    EXPECT_EQ(rig.b.all, (ByteVector{1}));
    EXPECT_EQ(rig.bus.next_wakeup(), kNever);
}

TEST(SerialBus, AChangeFromOutsideIsSeenAtOnce) {
    Rig rig;
    rig.run(10ms);
    rig.a.send(at(3ms), {9});
    rig.bus.run_until(at(10ms));
    rig.bus.run_until(at(11ms));
    EXPECT_EQ(rig.record.entries, (std::vector<Record::Entry>{{0, at(10ms), at(11ms), {9}, false}}));
}

}  // namespace serial_bus_test
}  // namespace takt::sim
