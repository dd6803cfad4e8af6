// Commands on a line: one outcome each.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "writing.hpp"

namespace takt::poll {
namespace command_test {

using namespace test;
using value::CommandResult;
using value::Reason;
using value::Value;

struct OutcomeCase {
    const char* what;
    bool on_change;
    bool repeatable;
    std::optional<std::uint8_t> exception;
    bool ignores;
    CommandResult result;
    Reason reason;
    std::size_t transmissions;
};

TEST(Command, EachCommandHasOneOutcome) {
    constexpr OutcomeCase kCases[] = {
        {"done", false, false, {}, false, CommandResult::done, Reason::ok, 1},
        {"done with its group", true, false, {}, false, CommandResult::done, Reason::ok, 1},
        {"refused", false, false, 3, false, CommandResult::refused, value::exception_reason(3), 1},
        {"its group refused", true, false, 3, false, CommandResult::refused, value::exception_reason(3), 1},
        {"busy to the end", false, false, 6, false, CommandResult::refused, value::exception_reason(6), 3},
        {"its group busy to the end", true, false, 6, false, CommandResult::refused,
         value::exception_reason(6), 3},
        {"accepted, not done yet", false, true, 5, false, CommandResult::unknown, value::exception_reason(5),
         1},
        {"behind a gateway", false, false, 11, false, CommandResult::unknown, value::exception_reason(11), 1},
        {"no answer", false, false, {}, true, CommandResult::unknown, Reason::timeout, 1},
        {"its group without answer", true, false, {}, true, CommandResult::unknown, Reason::timeout, 1},
        {"no answer, safe to repeat", false, true, {}, true, CommandResult::unknown, Reason::timeout, 3},
        {"its group, safe to repeat", true, true, {}, true, CommandResult::unknown, Reason::timeout, 3},
    };
    for (const auto& c : kCases) {
        auto written = int16("v", 0).write(0x06);  // not read: nothing else is on the line
        if (c.on_change) written = written.on_change();
        if (c.repeatable) written = written.repeatable();
        Bench bench(project({device(1, {written})}));
        bench.players[1].exception = c.exception;
        bench.players[1].ignores_writes = c.ignores;
        bench.run_until(50ms);
        ASSERT_TRUE(bench.write(9, "v", number(7), 60s)) << c.what;
        bench.run_until(10s);
        ASSERT_EQ(bench.outcomes.size(), 1U) << c.what;
        EXPECT_EQ(bench.outcomes[0].id, 9U) << c.what;
        EXPECT_EQ(bench.outcomes[0].result, c.result) << c.what;
        EXPECT_EQ(bench.outcomes[0].reason, c.reason) << c.what;
        EXPECT_EQ(bench.sent.size(), c.transmissions) << c.what;
    }
}

TEST(Command, ACommandThatIsNeverSentBecauseANewerValueCameIsNotDone) {
    Bench bench(
        project({device(1, {int16("v", 0).write(0x10).on_change(), int16("w", 1).write(0x10).on_change()})}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.set("w", number(0)));
    bench.link(false);
    ASSERT_TRUE(bench.write(1, "v", number(1), 60s));
    ASSERT_TRUE(bench.write(2, "v", number(2), 60s));
    ASSERT_TRUE(bench.write(3, "w", number(3), 60s));
    ASSERT_TRUE(bench.set("w", number(4)));
    ASSERT_TRUE(bench.write(4, "w", number(4), 60s));
    bench.link(true);
    bench.run_until(1s);
    std::map<value::CommandId, value::CommandOutcome> outcomes;
    for (const auto& outcome : bench.outcomes) ASSERT_TRUE(outcomes.emplace(outcome.id, outcome).second);
    for (const value::CommandId id : {1U, 3U}) {
        EXPECT_EQ(outcomes[id].result, CommandResult::refused);
        EXPECT_EQ(outcomes[id].reason, Reason::superseded);
    }
    for (const value::CommandId id : {2U, 4U}) EXPECT_EQ(outcomes[id].result, CommandResult::done);
    EXPECT_EQ(bench.players[1].registers[0], 2);
    EXPECT_EQ(bench.players[1].registers[1], 4);
}

// A client that writes repeatedly must not be overtaken for ever by another one that writes a little later.
TEST(Command, ANewerValueKeepsThePlaceOfTheOneItTakes) {
    Bench bench(
        project({device(1, {int16("v", 0).write(0x06).on_change(), int16("w", 9).write(0x06).on_change()})}));
    bench.players[1].turnaround = 45ms;
    Duration now = 50ms;
    value::CommandId id = 0;
    for (int i = 0; i < 60; ++i, now += 20ms) {
        bench.run_until(now);
        ASSERT_TRUE(bench.write(++id, "w", number(100 + i), 60s));
        ASSERT_TRUE(bench.write(++id, "v", number(200 + i), 60s));
    }
    std::map<std::uint16_t, int> written;
    for (const auto& sent : bench.sent) ++written[sent.start];
    EXPECT_GE(written[0], 8);
    EXPECT_GE(written[9], 8);
}

TEST(Command, WhatExpiredDoesNotComeBackWhenALaterCommandExpiresToo) {
    Bench bench(project({device(1, {int16("v", 0).read(3).write(0x10).write_on(0)})}, {local("go")}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.set("v", number(1)));
    bench.link(false);
    ASSERT_TRUE(bench.write(1, "v", number(2), 100ms));
    ASSERT_TRUE(bench.write(2, "v", number(3), 200ms));
    bench.run_until(1s);
    bench.link(true);
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(2s);
    EXPECT_EQ(bench.players[1].registers[0], 1);
}

TEST(Command, ACommandThatExpiresTakesNothingBackThatWasWantedOnceMore) {
    for (const bool by_command : {false, true}) {
        Bench bench(project({device(1, {boolean("c", 0, 0).read(1).write(0x05).on_change()})}));
        bench.run_until(50ms);
        ASSERT_TRUE(bench.set("c", false));
        bench.run_until(100ms);
        bench.link(false);
        ASSERT_TRUE(bench.write(1, "c", true, 100ms));
        if (by_command)
            ASSERT_TRUE(bench.write(2, "c", true, 60s));
        else
            ASSERT_TRUE(bench.set("c", true));
        bench.run_until(1s);
        bench.link(true);
        bench.run_until(2s);
        EXPECT_TRUE(bench.players[1].coils[0]) << by_command;
    }
}

TEST(Command, ARefusalAfterAnAttemptThatMayHaveBeenDoneIsNoProof) {
    for (const bool grouped : {false, true}) {
        auto written = int16("v", 0).write(0x06).repeatable();
        if (grouped) written = written.on_change();
        Bench bench(project({device(1, {written})}));
        bench.run_until(50ms);
        bench.players[1].ignores_writes = true;
        ASSERT_TRUE(bench.write(9, "v", number(7), 60s));
        bench.run_until(60ms);
        bench.players[1].ignores_writes = false;
        bench.players[1].exception = 3;
        bench.run_until(10s);
        ASSERT_EQ(bench.outcomes.size(), 1U);
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::unknown);
    }
}

TEST(Command, WhatWentWithAGroupThatWasNeverSentIsNotUnknown) {
    Bench bench(
        project({device(1, {int16("x", 10).read(3), int16("a", 0).write(0x10).write_on(0)})}, {local("go")}));
    bench.run_until(50ms);
    bench.observed.sendings.clear();
    ASSERT_TRUE(bench.set("a", number(5)));
    ASSERT_TRUE(bench.set("go", Value{true}));
    ASSERT_TRUE(bench.write(1, "a", number(5)));
    constexpr std::uint8_t kNoise[] = {0x55};
    auto& line = bench.master.line(0);
    while (bench.outcomes.empty() && bench.now < at(10s)) {
        bench.now += 250us;  // less than the silence before a request
        line.on_bytes(bench.now, kNoise);
        ASSERT_TRUE(line.transmit(bench.now).empty());
        while (const auto outcome = bench.master.take_outcome()) bench.outcomes.push_back(*outcome);
    }
    ASSERT_FALSE(bench.observed.sendings.empty());
    EXPECT_EQ(bench.observed.sendings.front().request, 1U);  // the group
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::refused);
}

TEST(Command, ALinkLostUnderAWriteLeavesItUnknownAndIsNotRepeated) {
    for (const bool repeatable : {false, true}) {
        auto written = int16("v", 0).write(0x06);
        Bench bench(project({device(1, {repeatable ? written.repeatable() : written})}));
        bench.players[1].dead = true;
        ASSERT_TRUE(bench.write(1, "v", number(7)));
        bench.run_until(20ms);
        ASSERT_EQ(bench.sent.size(), 1U);
        bench.link(false);
        bench.players[1].dead = false;
        bench.run_until(1s);
        bench.link(true);
        bench.run_until(2s);
        ASSERT_EQ(bench.outcomes.size(), 1U);
        EXPECT_EQ(bench.outcomes[0].result, repeatable ? CommandResult::done : CommandResult::unknown);
        EXPECT_EQ(bench.sent.size(), repeatable ? 2U : 1U);
    }
}

TEST(Command, ACommandWaitsForTheLinkUntilItExpires) {
    Bench bench(project({device(1, {int16("v", 0).write(0x06), int16("w", 5).write(0x06)})}));
    bench.link(false);
    ASSERT_TRUE(bench.write(1, "v", number(7), 100ms));
    ASSERT_TRUE(bench.write(2, "w", number(8), 10s));
    bench.run_until(200ms);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].id, 1U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::expired);
    EXPECT_TRUE(value::is_empty(bench.slot("v").wanted));
    EXPECT_EQ(bench.slot("w").wanted, number(8));
    bench.link(true);
    bench.run_until(300ms);
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_EQ(bench.outcomes[1].result, CommandResult::done);
    EXPECT_EQ(bench.sent.size(), 1U);
}

TEST(Command, ADeviceThatDoesNotAnswerRefusesCommandsAtOnce) {
    auto described = pair_on_change();
    described.poll_enable = 0;
    Bench bench(project({described, device(2, {int16("c", 0).read(3).write(0x06)})}, {local("on")}));
    bench.players[2].dead = true;
    ASSERT_TRUE(bench.write(1, "a", number(7)));
    bench.run_until(2s);
    ASSERT_TRUE(bench.write(2, "c", number(7)));
    bench.run_until(2010ms);
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_EQ(bench.outcomes[0].reason, Reason::switched_off);
    EXPECT_EQ(bench.outcomes[1].reason, Reason::not_answering);
    for (const auto& outcome : bench.outcomes) EXPECT_EQ(outcome.result, CommandResult::refused);
    EXPECT_TRUE(value::is_empty(bench.slot("a").wanted));
    EXPECT_TRUE(value::is_empty(bench.slot("c").wanted));
}

TEST(Command, CommandsThatWaitAreRefusedWhenTheirDeviceStopsAnswering) {
    Bench bench(project({device(1, {int16("a", 0).read(3), int16("c", 5).read(3).write(0x06).on_change(),
                                    int16("d", 6).read(3).write(0x06).on_change()})}));
    bench.players[1].dead = true;
    bench.run_until(250ms);
    ASSERT_TRUE(bench.set("d", number(1)));  // neither set nor read: "c" and "d" are groups of their own
    ASSERT_TRUE(bench.write(1, "c", number(7)));
    bench.run_until(3s);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_NE(bench.outcomes[0].result, CommandResult::done);
    bench.players[1].dead = false;
    bench.run_until(70s);
    EXPECT_EQ(bench.players[1].registers[5], 0);
}

TEST(Command, TheQueueOfCommandsIsBounded) {
    Bench bench(project({device(1, {int16("v", 0).write(0x06)})}));
    bench.link(false);
    for (std::size_t i = 0; i < LinePoller::kMaxCommands; ++i) ASSERT_TRUE(bench.write(i, "v", number(7)));
    EXPECT_EQ(bench.write(999, "v", number(7)).error().code, Code::queue_full);
    bench.link(true);
    bench.run_until(60s);
    EXPECT_EQ(bench.outcomes.size(), LinePoller::kMaxCommands);
    EXPECT_TRUE(bench.write(999, "v", number(7)));
}

TEST(Command, CommandsGoBeforeThePollingInTheirOrder) {
    auto described =
        project({device(1, {int16("r", 0).read(3).every(0ms)}), device(2, {int16("x", 0).write(0x06)}),
                 device(3, {int16("y", 0).write(0x06)})});
    described.lines[0].commands.burst = 2;
    Bench bench(described);
    bench.run_until(100ms);
    bench.news();
    ASSERT_TRUE(bench.write(1, "y", number(1)));
    ASSERT_TRUE(bench.write(2, "x", number(1)));
    bench.run_until(130ms);
    const auto sent = bench.news();
    const auto first = std::find_if(sent.begin(), sent.end(), [](const Sent& s) { return s.function == 6; });
    ASSERT_LE(first - sent.begin(), 1);
    EXPECT_EQ(first->unit, 3);
    EXPECT_EQ((first + 1)->unit, 2);
}

}  // namespace command_test
}  // namespace takt::poll
