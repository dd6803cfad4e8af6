#include "devices/close_watch.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace close_watch_test {

bus::Outcome ended(int unit, bus::Status status) {
    return {.unit = UnitId{static_cast<std::uint8_t>(unit)}, .status = status, .sent = true};
}

TEST(CloseWatch, SeveralAreSentOneAtATimeUntilACloseNamesOne) {
    CloseWatch watch;
    watch.closed(4);
    EXPECT_TRUE(watch.one_at_a_time());
    watch.ended(ended(1, bus::Status::link_lost));
    watch.ended(ended(1, bus::Status::timeout));
    EXPECT_TRUE(watch.one_at_a_time());
    watch.closed(1);
    EXPECT_FALSE(watch.one_at_a_time());
}

TEST(CloseWatch, APeerThatLikesNoTwoIsAskedOneAtATimeForLongerEachTime) {
    CloseWatch watch;
    for (const int expected : {4, 8, 16}) {
        watch.closed(4);
        int ends = 0;
        for (; watch.one_at_a_time(); ++ends) watch.ended(ended(1, bus::Status::timeout));
        EXPECT_EQ(ends, expected);
    }
    for (int i = 0; i < 20; ++i) watch.closed(4);
    std::size_t ends = 0;
    for (; watch.one_at_a_time(); ++ends) watch.ended(ended(1, bus::Status::timeout));
    EXPECT_EQ(ends, CloseWatch::kMostAlone);
}

TEST(CloseWatch, TheRowEndsWithAResponse) {
    CloseWatch watch;
    watch.ended(ended(1, bus::Status::closed));
    EXPECT_TRUE(watch.met_by(UnitId{1}));
    EXPECT_FALSE(watch.met_by_several());
    watch.ended(ended(2, bus::Status::closed));
    EXPECT_TRUE(watch.met_by_several());
    watch.ended(ended(3, bus::Status::timeout));
    EXPECT_TRUE(watch.met_by_several()) << "a time-out is no response";
    const std::uint8_t exception[] = {0x83, 2};
    auto answered = ended(3, bus::Status::exception);
    const auto asked = wire::prepare(wire::ReadRequest{Function::read_holding_registers, DataAddress{0}, 1});
    answered.response = *wire::decode_response(asked->shape(), asked->pdu(), exception);
    watch.ended(answered);
    EXPECT_FALSE(watch.met_by(UnitId{1}));
    watch.ended(ended(1, bus::Status::closed));
    watch.ended(ended(2, bus::Status::ambiguous));
    EXPECT_FALSE(watch.met_by(UnitId{1})) << "its request is in doubt, the line is not";
}

}  // namespace close_watch_test
}  // namespace takt::poll::test
