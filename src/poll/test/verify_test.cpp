// Verifying writes: read back next on the line, compared, and one outcome.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench.hpp"

namespace takt::poll {
namespace verify_test {

using namespace test;
using value::CommandResult;
using value::Reason;
using value::Value;

Value number(std::int64_t value) {
    return value;
}

std::string pdu(const Sent& sent) {
    return sent.bytes.substr(3, sent.bytes.size() - 9);
}

std::vector<std::string> pdus(const std::vector<Sent>& sent) {
    std::vector<std::string> all;
    for (const auto& one : sent) all.push_back(pdu(one));
    return all;
}

using Pdus = std::vector<std::string>;

TEST(Verify, EveryKindOfWriteIsReadBack) {
    struct Case {
        Item item;
        Value value;
        Pdus sent;
        bool fc22 = false;
        bool modify = false;
    };
    const Case kCases[] = {
        {int16("v", 4).write(0x06), number(-2), {"06 00 04 FF FE", "03 00 04 00 01"}},
        {int16("v", 4).write(0x10).on_change(), number(7), {"10 00 04 00 01 02 00 07", "03 00 04 00 01"}},
        {real("v", 4).write(0x10), 1.0, {"10 00 04 00 02 04 00 00 3F 80", "03 00 04 00 02"}},
        {boolean("v", 1, 3).write(0x05), true, {"05 00 13 FF 00", "01 00 13 00 01"}},
        {boolean("v", 1, 3).write(0x0F).on_change(), true, {"0F 00 13 00 01 01 01", "01 00 13 00 01"}},
        {boolean("v", 1, 3).read(3).write(0x06), true, {"16 00 01 FF F7 00 08", "03 00 01 00 01"}, true},
        {boolean("v", 1, 3).read(3).write(0x06).on_change(),
         true,
         {"16 00 01 FF F7 00 08", "03 00 01 00 01"},
         true},
        {boolean("v", 1, 3).read(3).write(0x06).on_change(),
         true,
         {"03 00 01 00 01", "06 00 01 00 88", "03 00 01 00 01"},
         false,
         true},
    };
    for (const auto& c : kCases) {
        auto described = device(1, {c.item.verified().every(1h)});
        described.fc22 = c.fc22;
        described.read_modify_write = c.modify;
        Bench bench(project({described}));
        bench.players[1].registers[1] = 0x80;
        bench.run_until(50ms);
        bench.news();
        ASSERT_TRUE(bench.write(1, "v", c.value)) << c.sent[0];
        bench.run_until(200ms);
        EXPECT_EQ(pdus(bench.news()), c.sent);
        ASSERT_EQ(bench.outcomes.size(), 1U) << c.sent[0];
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::done) << c.sent[0];
        EXPECT_TRUE(value::same(bench.slot("v").value, c.value)) << "what was read back is shown";
        EXPECT_EQ(bench.master.line(0).device(0).verified, 1U);
    }
}

TEST(Verify, AValueThatDiffersIsRefusedAndReportedWithBothValues) {
    for (const bool on_change : {false, true}) {
        auto item = int16("v", 0).read(3).write(0x10).verified().every(1h);
        Bench bench(project({device(1, {on_change ? item.on_change().reports_to(0) : item.reports_to(0)})},
                            {local("state", DataType::int16)}));
        bench.players[1].keeps = [](std::uint16_t written) { return std::min<std::uint16_t>(written, 49); };
        bench.run_until(50ms);
        ASSERT_TRUE(bench.write(3, "v", number(50)));
        bench.run_until(200ms);
        ASSERT_EQ(bench.outcomes.size(), 1U);
        const auto& outcome = bench.outcomes[0];
        EXPECT_EQ(outcome.result, CommandResult::refused);
        EXPECT_EQ(outcome.reason, Reason::differs);
        EXPECT_EQ(outcome.written, number(50));
        EXPECT_EQ(outcome.read_back, number(49));
        EXPECT_EQ(bench.observed.differing, (std::vector<std::pair<Value, Value>>{{number(50), number(49)}}));
        EXPECT_EQ(bench.slot("v").value, number(49));
        EXPECT_TRUE(value::is_empty(bench.slot("v").wanted)) << "what was refused is no longer wanted";
        EXPECT_EQ(bench.status("state"), 106);
        EXPECT_EQ(bench.master.line(0).device(0).differed, 1U);
        bench.news();
        bench.run_until(2s);
        EXPECT_TRUE(bench.news().empty()) << "not repeated";
    }
}

TEST(Verify, WhatIsSafeToRepeatIsSentAgainAsOftenAsTheProjectSays) {
    auto described = device(1, {int16("v", 0).write(0x06).verified().repeatable()});
    described.attempts = 2;  // one repeat and then dropped
    Bench bench(project({described}));
    bench.players[1].keeps = [](std::uint16_t) { return std::uint16_t{0}; };
    ASSERT_TRUE(bench.write(1, "v", number(50)));
    bench.run_until(2s);
    EXPECT_EQ(pdus(bench.news()),
              (Pdus{"06 00 00 00 32", "03 00 00 00 01", "06 00 00 00 32", "03 00 00 00 01"}));
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].reason, Reason::differs);
    int writes = 0;
    bench.players[1].keeps = [&writes](std::uint16_t value) {
        return ++writes == 1 ? std::uint16_t{0} : value;
    };
    ASSERT_TRUE(bench.write(2, "v", number(51)));
    bench.run_until(4s);
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_EQ(bench.outcomes[1].result, CommandResult::done);
}

struct Failing {
    const char* what;
    int lost;  // readings back that stay without an answer
    std::optional<std::uint8_t> exception;
    CommandResult result;
    Reason reason;
    std::size_t readings;
};

// Of "once": the lost one, two in doubt, and the one that counts. A reading back is not altered, so the lost
// response looks like those that follow. After two of them it counts as lost (OutstandingResponses).
TEST(Verify, AReadingBackThatFailsIsRepeatedAndThenTheOutcomeIsUnknown) {
    constexpr Failing kCases[] = {
        {"once", 1, {}, CommandResult::done, Reason::ok, 4},
        {"always", 99, {}, CommandResult::unknown, Reason::timeout, 3},
        {"refused", 0, 2, CommandResult::unknown, value::exception_reason(2), 1},
        {"busy", 0, 6, CommandResult::unknown, value::exception_reason(6), 3},
    };
    for (const auto& c : kCases)
        for (const bool on_change : {false, true}) {
            auto item = int16("v", 0).write(0x06).verified();
            Bench bench(project({device(1, {on_change ? item.on_change() : item})}));
            auto& player = bench.players[1];
            int readings = 0;
            player.silent_to = [&](const wire::Request& request) {
                if (!std::holds_alternative<wire::ReadRequest>(request)) return false;
                if (c.exception) player.exception = c.exception;
                return ++readings <= c.lost;
            };
            ASSERT_TRUE(bench.write(1, "v", number(5), 60s));
            bench.run_until(20s);
            ASSERT_EQ(bench.outcomes.size(), 1U) << c.what;
            EXPECT_EQ(bench.outcomes[0].result, c.result) << c.what;
            EXPECT_EQ(bench.outcomes[0].reason, c.reason) << c.what;
            EXPECT_EQ(bench.sent.size(), 1 + c.readings) << c.what << ": one write, and readings back";
            player.silent_to = {};
            player.exception.reset();
            bench.run_until(100s);
            ASSERT_TRUE(bench.write(2, "v", number(6), 60s)) << "and the next write goes";
            bench.run_until(102s);
            ASSERT_EQ(bench.outcomes.size(), 2U) << c.what;
            EXPECT_EQ(bench.outcomes[1].result, CommandResult::done) << c.what;
        }
}

TEST(Verify, WhatIsReadBackIsNextAndNothingElseIsWrittenToTheDeviceMeanwhile) {
    auto described = project({device(1, {int16("a", 0).write(0x06).verified(), int16("b", 9).write(0x06),
                                         int16("r", 20).read(3).every(0ms)})});
    described.lines[0].commands.burst = 3;
    Bench bench(described);
    bench.run_until(100ms);
    bench.news();
    ASSERT_TRUE(bench.write(1, "a", number(1)));
    ASSERT_TRUE(bench.write(2, "b", number(2)));
    ASSERT_TRUE(bench.write(3, "a", number(3)));
    bench.run_until(250ms);
    auto sent = pdus(bench.news());
    if (sent.front() == "03 00 14 00 01") sent.erase(sent.begin());  // was in flight
    ASSERT_GE(sent.size(), 5U);
    sent.resize(5);
    EXPECT_EQ(sent, (Pdus{"06 00 00 00 01", "03 00 00 00 01", "06 00 09 00 02", "06 00 00 00 03",
                          "03 00 00 00 01"}));
}

TEST(Verify, AValueSetMeanwhileIsComparedWithTheNextWriteNotWithThisOne) {
    Bench bench(project({device(1, {int16("v", 0).read(3).write(0x10).on_change().verified().every(1h)})}));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.write(1, "v", number(1)));
    bench.run_until(53ms);  // in flight
    ASSERT_TRUE(bench.write(2, "v", number(2)));
    bench.run_until(300ms);
    ASSERT_EQ(bench.outcomes.size(), 2U);
    for (const auto& outcome : bench.outcomes) EXPECT_EQ(outcome.result, CommandResult::done);
    EXPECT_TRUE(bench.observed.differing.empty());
    EXPECT_EQ(bench.players[1].registers[0], 2);
}

TEST(Verify, OfAGroupEachCommandLearnsOfItsOwnVariable) {
    Bench bench(project({device(1, {int16("a", 0).read(3).write(0x10).on_change().verified().every(1h),
                                    int16("b", 1).read(3).write(0x10).on_change().verified().every(1h)})}));
    bench.players[1].keeps = [](std::uint16_t written) { return written == 66 ? std::uint16_t{6} : written; };
    bench.run_until(50ms);
    ASSERT_TRUE(bench.write(1, "a", number(5)));
    ASSERT_TRUE(bench.write(2, "b", number(66)));
    bench.run_until(300ms);
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::done);
    EXPECT_EQ(bench.outcomes[1].result, CommandResult::refused);
    EXPECT_EQ(bench.outcomes[1].read_back, number(6));
}

// The group is written again for one of them; the other's value was done, also if another is wanted since.
TEST(Verify, OfAGroupThatIsRepeatedWhatWasDoneIsNotRefused) {
    auto described = device(1, {int16("a", 0).write(0x10).on_change().verified().repeatable().every(1h),
                                int16("b", 1).write(0x10).on_change().repeatable().every(1h)});
    described.attempts = 3;
    Bench bench(project({described}));
    bench.players[1].registers[0] = 9;
    bool once = false;
    bench.players[1].keeps = [&](std::uint16_t written) {
        return written == 1 && !std::exchange(once, true) ? std::uint16_t{9} : written;
    };
    bench.run_until(50ms);
    ASSERT_TRUE(bench.write(1, "a", number(1)));
    ASSERT_TRUE(bench.write(2, "b", number(2)));
    bench.news();
    while (bench.observed.sendings.empty() || bench.observed.sendings.back().purpose != Purpose::read_back)
        bench.run_until(bench.now - Instant{} + 100us);
    ASSERT_TRUE(bench.write(3, "b", number(3)));  // while that is read back
    bench.run_until(500ms);
    std::map<value::CommandId, CommandResult> results;
    for (const auto& outcome : bench.outcomes) results[outcome.id] = outcome.result;
    EXPECT_EQ(results, (std::map<value::CommandId, CommandResult>{
                           {1, CommandResult::done}, {2, CommandResult::done}, {3, CommandResult::done}}));
    EXPECT_EQ(bench.players[1].registers[0], 1);
    EXPECT_EQ(bench.players[1].registers[1], 3);
}

TEST(Verify, WhatCannotBeReadBackAnyMoreIsUnknown) {
    for (const bool on_change : {false, true})
        for (const char* how : {"link lost before", "link lost under way", "switched off"}) {
            auto item = int16("v", 0).write(0x06).verified().every(1h);
            auto described =
                device(1, {on_change ? item.on_change() : item, int16("r", 9).read(3).every(1h)});
            described.poll_enable = 0;
            auto enable = local("on");
            enable.default_value = model::Constant{.integer = 1};
            Bench bench(project({described}, {enable}));
            bench.run_until(50ms);
            const auto what = std::string(how);
            bench.players[1].silent_to = [&](const wire::Request& request) {
                return std::holds_alternative<wire::ReadRequest>(request);
            };
            ASSERT_TRUE(bench.write(1, "v", number(5)));
            bench.run_until(what == "link lost before" ? 57ms : 70ms);
            if (what == "switched off")
                ASSERT_TRUE(bench.set("on", false));
            else
                bench.link(false);
            bench.run_until(1s);
            ASSERT_EQ(bench.outcomes.size(), 1U) << how;
            EXPECT_EQ(bench.outcomes[0].result, CommandResult::unknown) << how;
            bench.players[1].silent_to = {};
            if (what == "switched off")
                ASSERT_TRUE(bench.set("on", true));
            else
                bench.link(true);
            bench.run_until(2s);
            ASSERT_TRUE(bench.write(2, "v", number(6)));
            bench.run_until(3s);
            ASSERT_EQ(bench.outcomes.size(), 2U) << how;
            EXPECT_EQ(bench.outcomes[1].result, CommandResult::done) << how;
        }
}

TEST(Verify, WhatIsReadBackFromADeviceSwitchedOffMeanwhileIsNoNews) {
    auto described =
        project({device(1, {int16("v", 4).read(3).write(0x06).verified().every(1h)})}, {local("on")});
    described.locals[0].default_value = model::Constant{.integer = 1};
    described.lines[0].devices[0].poll_enable = 0;
    Bench bench(described);
    bench.run_until(50ms);
    bench.players[1].turnaround = 3ms;
    ASSERT_TRUE(bench.write(1, "v", number(5)));
    while (bench.news().empty() || bench.sent.back().function != 3)
        bench.run_until(bench.now - Instant{} + 1ms);
    ASSERT_TRUE(bench.set("on", false));
    bench.run_until(500ms);
    EXPECT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.slot("v").quality, value::Quality::bad);
    EXPECT_EQ(bench.slot("v").reason, Reason::switched_off);
}

}  // namespace verify_test
}  // namespace takt::poll
