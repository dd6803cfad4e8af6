// Writing: on change, by triggers, by commands; and the one outcome each command has.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <string_view>

#include "bench.hpp"

namespace takt::poll {
namespace {

using namespace test;
using value::CommandResult;
using value::Reason;
using value::Value;

constexpr auto kNoWrites = [](const Sent& request) { return request.function < 5; };

std::vector<Sent> writes(Bench& bench) {
    auto news = bench.news();
    std::erase_if(news, kNoWrites);
    return news;
}

Value number(std::int64_t value) {
    return value;
}

model::Device pair_on_change() {
    return device(
        1, {int16("a", 0).read(3).write(0x10).on_change(), int16("b", 1).read(3).write(0x10).on_change()});
}

TEST(Writing, ASetMemberWritesItsWholeGroupWithWhatWasRead) {
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

TEST(Writing, AGroupWaitsForAMemberThatIsNeitherSetNorReadAndSaysSo) {
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
TEST(Writing, MembersThatAreNeitherSetNorReadAreWrittenWithTheirDefaults) {
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

TEST(Writing, WhatWasReadGoesBeforeTheDefault) {
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

TEST(Writing, ATriggerWritesBitsWithTheirDefaults) {
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

/// How a write is caused, and what it needs of its variable.
struct Cause {
    const char* name;
    Item item;
    std::function<void(Bench&, std::int64_t)> write;
};

std::vector<Cause> every_cause(const Item& item) {
    const auto by_trigger = [](Bench& bench, std::int64_t value) {
        ASSERT_TRUE(bench.set("go", false));
        ASSERT_TRUE(bench.set("v", value));
        ASSERT_TRUE(bench.set("go", true));
    };
    return {
        {"change", item.on_change(),
         [](Bench& bench, std::int64_t value) { ASSERT_TRUE(bench.set("v", value)); }},
        {"trigger", item.write_on(1), by_trigger},
        {"command", item, [](Bench& bench, std::int64_t value) { ASSERT_TRUE(bench.write(1, "v", value)); }},
        {"command of a group", item.on_change(),
         [](Bench& bench, std::int64_t value) { ASSERT_TRUE(bench.write(1, "v", value)); }}};
}

TEST(Writing, EveryFailedWriteSetsTheStatusWhateverCausedIt) {
    const auto item = int16("v", 0).write(0x06).reports_to(0);
    for (const auto& read : {item, item.read(3).every(1h)})
        for (const auto& cause : every_cause(read)) {
            SCOPED_TRACE(std::string(cause.name) + (read.model::Variable::read ? ", read" : ", not read"));
            auto described = device(1, {cause.item});
            described.poll_enable = 2;
            auto on = local("on");
            on.default_value = model::Constant{.number = 1, .integer = 1};
            Bench bench(project({described}, {local("state", DataType::int16), local("go"), on}));
            bench.run_until(50ms);
            bench.players[1].exception = 3;
            cause.write(bench, 5);
            bench.run_until(100ms);
            EXPECT_EQ(bench.status("state"), 3);
            bench.players[1].exception.reset();
            cause.write(bench, 6);
            bench.run_until(150ms);
            EXPECT_EQ(bench.status("state"), 0) << "after the next success";
            bench.players[1].dead = true;
            cause.write(bench, 7);
            bench.run_until(2s);
            EXPECT_EQ(bench.status("state"), 100);
            bench.link(false);
            EXPECT_EQ(bench.status("state"), 103);
            bench.players[1].dead = false;
            bench.link(true);
            cause.write(bench, 8);
            bench.run_until(3s);
            EXPECT_EQ(bench.status("state"), 0);
            ASSERT_TRUE(bench.set("on", false));
            EXPECT_EQ(bench.status("state"), 104);
        }
}

// A write that is refused at once sets the status too, also before the device was ever switched on.
TEST(Writing, AWriteToADeviceThatIsSwitchedOffSetsTheStatus) {
    for (const auto& cause : every_cause(int16("v", 0).write(0x06).reports_to(0))) {
        if (std::string_view(cause.name) == "change") continue;  // it waits for the device
        SCOPED_TRACE(cause.name);
        auto described = device(1, {cause.item});
        described.poll_enable = 2;
        Bench bench(project({described}, {local("state", DataType::int16), local("go"), local("on")}));
        bench.run_until(50ms);
        EXPECT_EQ(bench.status("state"), 0);
        cause.write(bench, 5);
        bench.run_until(100ms);
        EXPECT_EQ(bench.status("state"), 104);
    }
}

TEST(Writing, BitsThatAreNotSentKeepTheirStatus) {
    auto described = device(1, {boolean("a", 1, 0).read(3).write(0x06).on_change().reports_to(0).every(1h),
                                boolean("b", 1, 1).read(3).write(0x06).on_change().reports_to(1).every(1h)});
    described.fc22 = true;
    described.strategy = model::Strategy::optimal;
    Bench bench(project({described}, {local("sa", DataType::int16), local("sb", DataType::int16)}));
    bench.run_until(50ms);
    bench.players[1].exception = 3;
    ASSERT_TRUE(bench.set("b", true));
    bench.run_until(100ms);
    EXPECT_EQ(bench.status("sa"), 0);
    EXPECT_EQ(bench.status("sb"), 3);
}

// The end of every set is reported to the observer; the end of a command by its outcome.
TEST(Writing, HowAGroupThatWasSetEndedIsTold) {
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

TEST(Writing, ChangesThatComeTogetherAreWrittenOnce) {
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

TEST(Writing, WhatWasMerelyReadIsNoChange) {
    Bench bench(project({pair_on_change()}));
    bench.run_until(150ms);
    bench.players[1].registers = {{0, 5}, {1, 6}};
    bench.run_until(1s);
    EXPECT_TRUE(writes(bench).empty());
}

TEST(Writing, ATriggerWritesItsGroupOnce) {
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

TEST(Writing, EveryFunctionWritesItsOwnKindOfRequest) {
    struct Case {
        Item item;
        Value value;
        const char* pdu;
    };
    const Case kCases[] = {
        {boolean("v", 1, 3).read(1).write(0x05), true, "05 00 13 FF 00"},
        {boolean("v", 1, 3).read(1).write(0x05), false, "05 00 13 00 00"},
        {boolean("v", 1, 3).read(1).write(0x0F), true, "0F 00 13 00 01 01 01"},
        {int16("v", 4).read(3).write(0x06), number(-2), "06 00 04 FF FE"},
        {int16("v", 4).read(3).write(0x10), number(258), "10 00 04 00 01 02 01 02"},
        {real("v", 4).read(3).write(0x10), 1.0, "10 00 04 00 02 04 00 00 3F 80"},
    };
    for (const auto& c : kCases) {
        Bench bench(project({device(1, {c.item})}));
        bench.run_until(50ms);
        ASSERT_TRUE(bench.write(1, "v", c.value));
        bench.run_until(99ms);
        const auto sent = writes(bench);
        ASSERT_EQ(sent.size(), 1U) << c.pdu;
        EXPECT_EQ(sent[0].bytes.substr(3, sent[0].bytes.size() - 9), c.pdu);
        ASSERT_EQ(bench.outcomes.size(), 1U);
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::done);
        bench.run_until(150ms);
        EXPECT_TRUE(value::same(bench.slot("v").value, c.value)) << c.pdu;
    }
}

TEST(Writing, ScaledValuesGoBackExactlyAndRoundingIsSaid) {
    auto scaled = int16("v", 0).read(3).write(0x06);
    scaled.scale = 0.1;
    scaled.offset = -40;
    Bench bench(project({device(1, {scaled})}));
    bench.run_until(50ms);
    EXPECT_FALSE(bench.write(1, "v", 25.3).value());
    bench.run_until(90ms);
    EXPECT_EQ(bench.players[1].registers[0], 653);
    EXPECT_TRUE(bench.write(2, "v", 25.34).value());
    bench.run_until(150ms);
    EXPECT_EQ(bench.slot("v").value, Value(25.3));
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_FALSE(bench.outcomes[0].rounded);
    EXPECT_TRUE(bench.outcomes[1].rounded);
    EXPECT_EQ(bench.write(3, "v", 4000.0).error().code, Code::overflow);
}

TEST(Writing, WhatCannotBeWrittenIsRefusedAtOnce) {
    auto unused = int16("unused", 9).read(3).write(0x06);
    unused.used = false;
    Bench bench(project({device(1, {int16("v", 0).read(3).write(0x06), int16("input", 4).read(4), unused})}));
    EXPECT_EQ(bench.write(1, "v", number(40000)).error().code, Code::overflow);
    EXPECT_EQ(bench.write(1, "v", std::string("x")).error().code, Code::unsupported);
    EXPECT_EQ(bench.write(1, "input", number(1)).error().code, Code::not_writable);
    EXPECT_EQ(bench.set("input", number(1)).error().code, Code::not_writable);
    EXPECT_EQ(bench.write(1, "unused", number(1)).error().code, Code::not_writable);
    EXPECT_TRUE(bench.outcomes.empty());
}

TEST(Writing, WhatCannotBeReadShowsWhatWasWritten) {
    Bench bench(project({device(1, {int16("v", 0).write(0x06)})}));
    ASSERT_TRUE(bench.write(1, "v", number(7)));
    bench.run_until(50ms);
    EXPECT_EQ(bench.slot("v").value, number(7));
    EXPECT_EQ(bench.slot("v").quality, value::Quality::good);
}

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

TEST(Writing, EachCommandHasOneOutcome) {
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

TEST(Writing, ACommandThatIsNeverSentBecauseANewerValueCameIsNotDone) {
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
TEST(Writing, ANewerValueKeepsThePlaceOfTheOneItTakes) {
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

TEST(Writing, WhatExpiredDoesNotComeBackWhenALaterCommandExpiresToo) {
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

TEST(Writing, ACommandThatExpiresTakesNothingBackThatWasWantedOnceMore) {
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

TEST(Writing, ARefusalAfterAnAttemptThatMayHaveBeenDoneIsNoProof) {
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

// Its command has its outcome: a value that only this command asked for is not written any more.
TEST(Writing, AGroupIsRepeatedForWhatIsStillAskedFor) {
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

TEST(Writing, WhatWentWithAGroupThatWasNeverSentIsNotUnknown) {
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

TEST(Writing, ALinkLostUnderAWriteLeavesItUnknownAndIsNotRepeated) {
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

TEST(Writing, ACommandWaitsForTheLinkUntilItExpires) {
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

TEST(Writing, ADeviceThatDoesNotAnswerRefusesCommandsAtOnce) {
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

TEST(Writing, CommandsThatWaitAreRefusedWhenTheirDeviceStopsAnswering) {
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

TEST(Writing, TheQueueOfCommandsIsBounded) {
    Bench bench(project({device(1, {int16("v", 0).write(0x06)})}));
    bench.link(false);
    for (std::size_t i = 0; i < LinePoller::kMaxCommands; ++i) ASSERT_TRUE(bench.write(i, "v", number(7)));
    EXPECT_EQ(bench.write(999, "v", number(7)).error().code, Code::queue_full);
    bench.link(true);
    bench.run_until(60s);
    EXPECT_EQ(bench.outcomes.size(), LinePoller::kMaxCommands);
    EXPECT_TRUE(bench.write(999, "v", number(7)));
}

TEST(Writing, CommandsGoBeforeThePollingInTheirOrder) {
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

TEST(Writing, ALocalIsWrittenAtOnce) {
    Bench bench(project({device(1, {int16("v", 0).read(3)})}, {local("go")}));
    ASSERT_TRUE(bench.write(5, "go", true));
    bench.run_until(1ms);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::done);
    EXPECT_EQ(bench.slot("go").value, Value(true));
    EXPECT_EQ(bench.write(6, "go", number(2)).error().code, Code::overflow);
}

TEST(Writing, WhatItsReadTriggerIsAdmittedWithHoldsBackNoWrite) {
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

}  // namespace
}  // namespace takt::poll
