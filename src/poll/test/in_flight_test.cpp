// Modbus TCP: several requests in flight at once.
#include <gtest/gtest.h>

#include <set>

#include "tcp_frames.hpp"

namespace takt::poll {
namespace in_flight_test {

using namespace test;

/// A TCP line with one device that takes `in_flight` requests; the test answers by hand.
class Connection {
public:
    Connection(int in_flight, std::vector<Item> items)
        : project_(described(in_flight, std::move(items))),
          plan_(plan::make_plan(project_)),
          master_(project_, plan_) {
        master_.line(0).on_link(now_, true);
    }

    /// The frames that it sends now (MBAP).
    std::vector<std::vector<std::uint8_t>> sent() {
        std::vector<std::vector<std::uint8_t>> frames;
        for (;;) {
            const Bytes bytes = master_.line(0).transmit(now_);
            if (bytes.empty()) return frames;
            frames.emplace_back(bytes.begin(), bytes.end());
        }
    }

    /// Answers with registers or with the echo of a write.
    void answer(const std::vector<std::uint8_t>& frame, std::uint8_t content = 0) {
        auto pdu = pdu_of(frame);
        if (pdu[0] == 3) pdu = {3, 2, 0, content};
        if (pdu[0] == 0x10) pdu.resize(5);
        now_ += 1ms;
        master_.line(0).on_bytes(now_, tcp_response(frame, pdu));
    }

    Master& master() { return master_; }
    [[nodiscard]] Instant now() const { return now_; }

private:
    static model::Project described(int in_flight, std::vector<Item> items) {
        auto made = device(1, items);
        made.strategy = model::Strategy::single;
        made.in_flight = static_cast<std::uint16_t>(in_flight);
        made.read_modify_write = true;
        return tcp_project({made});
    }

    model::Project project_;
    plan::Plan plan_;
    Master master_;
    Instant now_ = at(0ms);
};

std::vector<Item> eight() {
    std::vector<Item> items;
    for (int i = 0; i < 8; ++i) items.push_back(int16("v" + std::to_string(i), 10 * i).read(3).every(0ms));
    return items;
}

TEST(InFlight, AsManyAsTheDeviceTakesAndEachOnce) {
    Connection one(1, eight());
    EXPECT_EQ(one.sent().size(), 1U);
    Connection four(4, eight());
    const auto first = four.sent();
    ASSERT_EQ(first.size(), 4U);
    std::set<std::uint8_t> starts;
    for (const auto& frame : first) starts.insert(frame[9]);
    EXPECT_EQ(starts.size(), 4U);
    // The last is answered first: its transaction id identifies it.
    four.answer(first[3], 42);
    const auto last = four.master().store().find("v" + std::to_string(first[3][9] / 10));
    EXPECT_EQ(four.master().store()[*last].value, value::Value(std::int64_t{42}));
    const auto next = four.sent();
    ASSERT_EQ(next.size(), 1U);
    EXPECT_FALSE(starts.contains(next[0][9]));
}

TEST(InFlight, WritesKeepTheirOrder) {
    Connection four(4, {int16("a", 0).write(0x06), int16("b", 5).write(0x06)});
    for (value::CommandId i = 1; i <= 2; ++i)
        ASSERT_TRUE(four.master().write(
            four.now(), {i, *four.master().store().find(i == 1 ? "a" : "b"), std::int64_t{7}}));
    const auto first = four.sent();
    ASSERT_EQ(first.size(), 1U);
    EXPECT_EQ(first[0][9], 0);
    four.answer(first[0]);
    const auto second = four.sent();
    ASSERT_EQ(second.size(), 1U);
    EXPECT_EQ(second[0][9], 5);
}

TEST(InFlight, AReadModifyWriteIsAloneOnTheConnection) {
    auto items = eight();
    items.push_back(boolean("bit", 100, 1).write(0x06));
    Connection four(4, items);
    const auto before = four.sent();
    ASSERT_EQ(before.size(), 4U);
    ASSERT_TRUE(four.master().write(four.now(), {1, *four.master().store().find("bit"), true}));
    for (const auto& frame : before) {
        EXPECT_TRUE(four.sent().empty());
        four.answer(frame);
    }
    const auto read = four.sent();
    ASSERT_EQ(read.size(), 1U);
    EXPECT_EQ(read[0][7], 3);
    EXPECT_EQ(read[0][9], 100);
    four.answer(read[0], 0x80);
    const auto written = four.sent();
    ASSERT_GE(written.size(), 1U);
    EXPECT_EQ(written[0][7], 6);
    EXPECT_EQ(written[0][11], 0x82);
    EXPECT_EQ(written.size(), 4U) << "the polling goes on";
}

}  // namespace in_flight_test
}  // namespace takt::poll
