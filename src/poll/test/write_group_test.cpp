// Groups on a line: written on change and by triggers.
#include <gtest/gtest.h>

#include "writing.hpp"

namespace takt::poll {
namespace write_group_test {

using namespace test;
using value::CommandResult;
using value::Reason;

TEST(WriteGroup, ASetMemberWritesItsWholeGroupWithWhatWasRead) {
    Bench bench(project({pair_on_change()}));
    bench.players[1].registers = {{0, 5}, {1, 6}};
    bench.run_until(50ms);
    bench.news();
    ASSERT_FALSE(bench.set("b", number(7)).value());
    bench.run_until(60ms);
    const auto sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 32), "01 10 00 00 00 02 04 00 05 00 07");
    EXPECT_EQ(bench.slot("b").wanted, number(7));
    EXPECT_EQ(bench.slot("b").value, number(6));  // until it is read again
    bench.run_until(150ms);
    EXPECT_EQ(bench.slot("b").value, number(7));
    // The last value set counts, also where another master changed the device since.
    bench.players[1].registers[1] = 9;
    bench.run_until(250ms);
    ASSERT_TRUE(bench.set("a", number(1)));
    bench.run_until(260ms);
    EXPECT_EQ(writes(bench)[0].bytes.substr(0, 32), "01 10 00 00 00 02 04 00 01 00 07");
}

TEST(WriteGroup, AGroupWaitsForAMemberThatIsNeitherSetNorReadAndSaysSo) {
    Bench bench(project({pair_on_change()}));
    bench.players[1].refuses = {{0, 2}};
    ASSERT_TRUE(bench.set("a", number(7)));
    bench.run_until(1s);
    EXPECT_TRUE(writes(bench).empty());
    EXPECT_EQ(bench.observed.waiting, std::vector<std::size_t>{1});
    bench.players[1].refuses.clear();
    ASSERT_TRUE(bench.set("b", number(8)));
    bench.run_until(1010ms);
    EXPECT_EQ(writes(bench).size(), 1U);
}

// A default value is what a variable holds at the start (docs/specification.md, section 7).
TEST(WriteGroup, MembersThatAreNeitherSetNorReadAreWrittenWithTheirDefaults) {
    Bench bench(project({device(1, {int16("a", 0).write(0x10).write_on(0).defaults_to(11),
                                    int16("b", 1).write(0x10).write_on(0).defaults_to(-2)})},
                        {local("go")}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(100ms);
    auto sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 32), "01 10 00 00 00 02 04 00 0B FF FE");
    EXPECT_TRUE(bench.observed.waiting.empty());
    ASSERT_TRUE(bench.set("a", number(7)));
    ASSERT_TRUE(bench.set("go", false));
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(150ms);
    sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 32), "01 10 00 00 00 02 04 00 07 FF FE");
}

TEST(WriteGroup, WhatWasReadGoesBeforeTheDefault) {
    const auto item = [](const char* name, int place) {
        return int16(name, place).read(3).write(0x10).on_change().defaults_to(9);
    };
    Bench bench(project({device(1, {item("a", 0), item("b", 1)})}));
    bench.players[1].refuses = {{0, 2}};
    ASSERT_TRUE(bench.set("a", number(7)));
    bench.run_until(50ms);
    bench.players[1].refuses.clear();
    auto sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 32), "01 10 00 00 00 02 04 00 07 00 09");
    bench.players[1].registers = {{0, 5}, {1, 6}};
    bench.run_until(150ms);
    ASSERT_TRUE(bench.set("a", number(8)));
    bench.run_until(199ms);
    sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 32), "01 10 00 00 00 02 04 00 08 00 06");
}

TEST(WriteGroup, ATriggerWritesBitsWithTheirDefaults) {
    auto described = device(1, {boolean("a", 1, 0).write(0x06).write_on(0).defaults_to(1),
                                boolean("b", 1, 3).write(0x06).write_on(0).defaults_to(0)});
    described.fc22 = true;
    described.strategy = model::Strategy::optimal;
    Bench bench(project({described}, {local("go")}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(100ms);
    const auto sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 23), "01 16 00 01 FF F6 00 01");
}

// The end of every set is reported to the observer; the end of a command by its outcome.
TEST(WriteGroup, TheOutcomeOfAGroupThatWasSetIsReported) {
    using Settled = RecordingObserver::Settled;
    Bench bench(project({pair_on_change()}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.set("b", number(7)));
    bench.run_until(60ms);
    EXPECT_EQ(bench.observed.settled, (std::vector<Settled>{{{1}, CommandResult::done, Reason::ok}}));
    bench.observed.settled.clear();
    bench.players[1].exception = 4;
    ASSERT_TRUE(bench.set("a", number(8)));
    ASSERT_TRUE(bench.set("b", number(9)));
    bench.run_until(70ms);
    EXPECT_EQ(bench.observed.settled,
              (std::vector<Settled>{{{0, 1}, CommandResult::refused, value::exception_reason(4)}}));
    bench.observed.settled.clear();
    ASSERT_TRUE(bench.set("a", number(10)));
    ASSERT_TRUE(bench.write(1, "b", number(11)));
    bench.run_until(80ms);
    EXPECT_EQ(bench.observed.settled,
              (std::vector<Settled>{{{0}, CommandResult::refused, value::exception_reason(4)}}));
    EXPECT_EQ(bench.outcomes.size(), 1U);
}

TEST(WriteGroup, ChangesThatComeTogetherAreWrittenOnce) {
    Bench bench(project({pair_on_change()}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.set("a", number(1)));
    ASSERT_TRUE(bench.set("b", number(2)));
    ASSERT_TRUE(bench.set("a", number(3)));
    bench.run_until(99ms);
    const auto sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 32), "01 10 00 00 00 02 04 00 03 00 02");
}

TEST(WriteGroup, WhatWasMerelyReadIsNoChange) {
    Bench bench(project({pair_on_change()}));
    bench.run_until(150ms);
    bench.players[1].registers = {{0, 5}, {1, 6}};
    bench.run_until(1s);
    EXPECT_TRUE(writes(bench).empty());
}

TEST(WriteGroup, ATriggerWritesItsGroupOnce) {
    Bench bench(project({device(1, {int16("a", 0).read(3).write(0x06).write_on(0)})}, {local("go")}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.set("a", number(7)));
    bench.run_until(1s);
    EXPECT_TRUE(writes(bench).empty());
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(1050ms);
    const auto sent = writes(bench);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(sent[0].bytes.substr(0, 17), "01 06 00 00 00 07");
    bench.run_until(2s);
    EXPECT_TRUE(writes(bench).empty());
}

// Its command has its outcome: a value that only this command asked for is not written any more.
TEST(WriteGroup, AGroupIsRepeatedForWhatIsStillAskedFor) {
    for (const bool set_too : {false, true}) {
        auto pair = pair_on_change();
        for (auto& variable : pair.variables) variable.safe_to_repeat = true;
        Bench bench(project({pair}));
        bench.players[1].silent_to = [](const wire::Request& request) {
            return std::holds_alternative<wire::WriteMultipleRegistersRequest>(request);
        };
        bench.run_until(50ms);
        if (set_too) {
            ASSERT_TRUE(bench.set("a", number(3)));
        }
        ASSERT_TRUE(bench.write(1, "b", number(7), 1ms));
        bench.run_until(5s);
        ASSERT_EQ(bench.outcomes.size(), 1U);
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::unknown);
        const auto times = writes(bench).size();
        EXPECT_TRUE(set_too ? times > 1 : times == 1) << times;
    }
}

TEST(WriteGroup, WhatItsReadTriggerIsAdmittedWithHoldsBackNoWrite) {
    auto described = project({device(1, {int16("a", 0).read(3).write(0x06).read_on(0).write_on(1)})},
                             {local("look"), local("go")});
    described.locals[0].admission = model::RateLimit{10s, 1};
    Bench bench(described);
    bench.run_until(20ms);
    for (const value::CommandId id : {1U, 2U, 3U})
        ASSERT_TRUE(bench.write(id, "a", static_cast<std::int64_t>(id)));
    bench.run_until(100ms);
    EXPECT_EQ(bench.outcomes.size(), 3U);
    EXPECT_EQ(bench.players[1].registers[0], 3);
}

}  // namespace write_group_test
}  // namespace takt::poll
