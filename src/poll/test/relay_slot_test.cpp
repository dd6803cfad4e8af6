#include "line/relay_slot.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace relay_slot_test {

constexpr UnitId kUnit{7};
constexpr Duration kInterval = 100ms;

bus::Transaction transaction(const wire::Request& request) {
    return {.id = 42, .unit = kUnit, .request = wire::prepare(request).value()};
}
const bus::Transaction kRead = transaction(wire::ReadRequest{Function::read_holding_registers, {}, 1});
const bus::Transaction kWrite = transaction(wire::WriteSingleRegisterRequest{});

bus::Outcome answered(Instant t) {
    return {.unit = kUnit, .status = bus::Status::ok, .ended_at = t};
}

/// Sends what waits.
void start(RelaySlot& slot, Instant t) {
    EXPECT_EQ(kind_of(slot.start(t).id), JobKind::relayed);
    slot.submitted(t);
}

TEST(RelaySlot, HoldsOneTransactionUntilItsOutcomeIsTaken) {
    RelaySlot slot(kInterval);
    EXPECT_TRUE(slot.empty());
    EXPECT_FALSE(slot.waiting());
    ASSERT_TRUE(slot.put(kRead, 3));
    EXPECT_FALSE(slot.empty());
    EXPECT_TRUE(slot.waiting());
    EXPECT_EQ(slot.device(), 3U);
    EXPECT_EQ(slot.unit(), kUnit);
    start(slot, at(1s));
    EXPECT_FALSE(slot.waiting());
    EXPECT_TRUE(slot.end(answered(at(2s)), at(2s)));
    EXPECT_FALSE(slot.empty()) << "the outcome was not taken";
    const auto outcome = slot.take_outcome();
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->id, 42U) << "that of the client";
    EXPECT_TRUE(slot.empty());
    EXPECT_FALSE(slot.take_outcome());
}

TEST(RelaySlot, KnowsWhetherItOnlyReads) {
    for (const bool reads : {false, true}) {
        RelaySlot slot(kInterval);
        ASSERT_TRUE(slot.put(reads ? kRead : kWrite, std::nullopt));
        EXPECT_EQ(slot.only_reads(), reads);
    }
}

TEST(RelaySlot, AnEmptyRequestIsRejected) {
    RelaySlot slot(kInterval);
    EXPECT_EQ(slot.put({.unit = kUnit}, std::nullopt).error().code, Code::out_of_range);
    EXPECT_TRUE(slot.empty());
}

TEST(RelaySlot, OnlyWhatWaitsIsWithdrawn) {
    RelaySlot slot(kInterval);
    EXPECT_FALSE(slot.withdraw());
    ASSERT_TRUE(slot.put(kRead, std::nullopt));
    EXPECT_TRUE(slot.withdraw());
    EXPECT_TRUE(slot.empty());
    ASSERT_TRUE(slot.put(kRead, std::nullopt));
    start(slot, at(1s));
    EXPECT_FALSE(slot.withdraw());
}

TEST(RelaySlot, OneEachIntervalGoesBeforePolling) {
    RelaySlot slot(kInterval);
    const auto urgency = [&](Duration t) { return slot.candidate(at(t)).urgency; };
    ASSERT_TRUE(slot.put(kRead, std::nullopt));
    EXPECT_EQ(urgency(1s), Urgency::relayed);
    start(slot, at(1s));
    ASSERT_TRUE(slot.end(answered(at(1010ms)), at(1020ms)));
    ASSERT_TRUE(slot.take_outcome());
    ASSERT_TRUE(slot.put(kRead, std::nullopt));
    EXPECT_EQ(urgency(1119ms), Urgency::background) << "counted from the moment the line is free";
    EXPECT_EQ(urgency(1120ms), Urgency::relayed);
    EXPECT_EQ(slot.candidate(at(1119ms)).key, at(1s).time_since_epoch().count());
}

TEST(RelaySlot, WhatIsGivenUpEndsAtOnceAndDropsTheLaterOutcome) {
    for (const bool sent : {false, true}) {
        RelaySlot slot(kInterval);
        ASSERT_TRUE(slot.put(kRead, std::nullopt));
        if (sent) start(slot, at(1s));
        slot.give_up(at(2s), bus::Status::link_lost, at(2s));
        EXPECT_FALSE(slot.end(answered(at(3s)), at(3s)));
        const auto outcome = slot.take_outcome();
        ASSERT_TRUE(outcome);
        EXPECT_EQ(outcome->status, bus::Status::link_lost);
        EXPECT_EQ(outcome->ended_at, at(2s));
        EXPECT_EQ(outcome->unit, kUnit);
        slot.give_up(at(4s), bus::Status::link_lost, at(4s));
        EXPECT_TRUE(slot.empty()) << "nothing to give up";
    }
}

}  // namespace relay_slot_test
}  // namespace takt::poll::test
