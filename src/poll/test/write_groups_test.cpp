// Groups without a line: what makes them due, what is written, and what is left when a write ends.
#include "writes/write_groups.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "write_fixture.hpp"

namespace takt::poll::test {
namespace write_groups_test {

using value::CommandResult;
using value::Reason;
using value::Value;

constexpr std::size_t kGroup = 2;
constexpr OutcomeClass kTimeout{Reason::timeout};
constexpr OutcomeClass kBusy{value::exception_reason(6), true, true};

/// One group that writes all variables on change and by a trigger.
class Groups : public WriteFixture {
public:
    explicit Groups(const std::vector<Item>& items, WriteKind kind = WriteKind::whole)
        : WriteFixture(items), commands(values, 16), groups(values, commands, arrivals) {
        planned.start = models.front().register_number;
        planned.quantity = kind == WriteKind::whole ? static_cast<std::uint16_t>(items.size()) : 1;
        groups.add(kGroup, described(kind), true, true);
    }

    void set(std::size_t variable, const Value& value) {
        values.want(variable, written(variable, value));
        groups.set(now, variable);
        commands.supersede(now, variable, value);
    }
    void command(std::size_t variable, const Value& value) {
        PendingCommand command{.command = {++last_, slot(variable), value},
                               .variable = variable,
                               .order = last_,
                               .group = kGroup,
                               .before = values.wanted(variable)};
        command.want = values.want(variable, written(variable, value));
        groups.ask(now, kGroup);
        commands.add(now, std::move(command));
    }
    /// Begins the write; the first request.
    std::string begin() {
        const auto first = groups.begin(kGroup);
        return first ? hex(first->pdu()) : "error";
    }
    /// Ends it; what is reported.
    std::vector<std::size_t> finish(CommandResult result = CommandResult::done, Reason reason = Reason::ok) {
        groups.transaction_ended(kGroup);
        const auto settled = groups.finish(now, kGroup, result, reason);
        by_trigger = settled.by_trigger;
        return {settled.variables.begin(), settled.variables.end()};
    }

    CommandQueue commands;
    ArrivalCounter arrivals;
    plan::Request planned;
    WriteGroups groups;
    Instant now = at(1s);
    bool by_trigger = false;

private:
    [[nodiscard]] WriteGroup described(WriteKind kind) const {
        WriteGroup group{.plan = &planned, .kind = kind};
        if (kind == WriteKind::modify) group.function = wire::Function::write_single_register;
        for (std::size_t v = 0; v < models.size(); ++v) group.members.push_back(v);
        if (models.front().verify) group.read_back = std::make_unique<ReadBack>(read_back_of(models.front()));
        return group;
    }
    value::CommandId last_ = 0;
};

Item word(int number) {
    return int16("w", number).read(3).write(0x10);
}
Item bit(int number) {
    return boolean("b", 7, number).read(3).write(0x06);
}

TEST(WriteGroups, VariablesFindTheirGroups) {
    Groups line({word(0)});
    EXPECT_TRUE(line.groups.has(kGroup));
    EXPECT_FALSE(line.groups.has(0));
    EXPECT_FALSE(line.groups.has(9));
    EXPECT_EQ(line.groups.on_change(0), kGroup);
    EXPECT_EQ(line.groups.by_trigger(0), kGroup);
    EXPECT_FALSE(line.groups.on_change(5));
}

TEST(WriteGroups, EachCauseMakesItDueOnce) {
    const std::pair<const char*, std::function<void(Groups&)>> kCauses[] = {
        {"set", [](Groups& line) { line.set(0, number(1)); }},
        {"trigger", [](Groups& line) { line.groups.pull_trigger(line.now, kGroup); }},
        {"command", [](Groups& line) { line.command(0, number(1)); }},
    };
    for (const auto& [what, cause] : kCauses) {
        SCOPED_TRACE(what);
        Groups line({word(0).defaults_to(5)});
        EXPECT_FALSE(line.groups.due(kGroup));
        cause(line);
        EXPECT_TRUE(line.groups.due(kGroup));
        EXPECT_TRUE(line.groups.ready(kGroup));
        EXPECT_NE(line.begin(), "error");
        EXPECT_FALSE(line.groups.due(kGroup));
        cause(line);
        EXPECT_TRUE(line.groups.due(kGroup)) << "what arrives meanwhile leads to another write";
        line.finish();
        EXPECT_TRUE(line.groups.due(kGroup));
        EXPECT_TRUE(line.groups[kGroup].progress.queued());
    }
}

TEST(WriteGroups, IsWrittenWithTheLatestValueOfEachMember) {
    Groups line({word(0), word(1)});
    line.values.note_read(0, number(5));
    line.values.note_read(1, number(6));
    line.set(1, number(7));
    line.set(1, number(8));
    EXPECT_EQ(line.begin(), "10 00 00 00 02 04 00 05 00 08");
}

TEST(WriteGroups, ReportsAMemberWithoutAValueOnce) {
    Groups line({word(0), word(1)});
    line.set(0, number(1));
    EXPECT_FALSE(line.groups.ready(kGroup));
    EXPECT_FALSE(line.groups.ready(kGroup));
    const auto waiting = line.groups.take_waiting();
    ASSERT_TRUE(waiting);
    EXPECT_EQ(waiting->group, kGroup);
    EXPECT_EQ(waiting->variable, 1U);
    EXPECT_FALSE(line.groups.take_waiting());
    line.values.note_read(1, number(2));
    EXPECT_TRUE(line.groups.ready(kGroup));
}

TEST(WriteGroups, OnlyBitsThatWereSetAreWritten) {
    struct Case {
        const char* what;
        std::function<void(Groups&)> cause;
        const char* pdu;
    };
    const Case kCases[] = {
        {"set", [](Groups& line) { line.set(1, true); }, "16 00 07 FF FD 00 02"},
        {"two", [](Groups& line) { line.set(1, true), line.set(0, false); }, "16 00 07 FF FC 00 02"},
        {"command", [](Groups& line) { line.command(0, true); }, "16 00 07 FF FE 00 01"},
        {"trigger, none ever set", [](Groups& line) { line.groups.pull_trigger(line.now, kGroup); },
         "16 00 07 FF FC 00 01"},
        {"trigger, one set before",
         [](Groups& line) {
             line.set(1, true);
             line.begin();
             line.finish();
             line.groups.pull_trigger(line.now, kGroup);
         },
         "16 00 07 FF FD 00 02"},
    };
    for (const auto& c : kCases) {
        SCOPED_TRACE(c.what);
        Groups line({bit(0), bit(1)}, WriteKind::mask);
        line.values.note_read(0, true);
        line.values.note_read(1, false);
        c.cause(line);
        ASSERT_TRUE(line.groups.ready(kGroup));
        EXPECT_EQ(line.begin(), c.pdu);
    }
}

TEST(WriteGroups, AReadModifyWriteWritesWhatIsWantedAfterTheRead) {
    Groups line({bit(0), bit(1)}, WriteKind::modify);
    line.set(0, true);
    EXPECT_EQ(line.begin(), "03 00 07 00 01");
    EXPECT_EQ(line.groups[kGroup].progress.phase(), WritePhase::reading_old);
    line.groups.transaction_ended(kGroup);
    line.set(0, false);
    line.set(1, true);  // not a bit of this write
    const auto second = line.groups.modify(line.now, kGroup, 0xFF01);
    ASSERT_TRUE(second);
    EXPECT_EQ(hex(second->pdu()), "06 00 07 FF 00");
    line.groups.second_step_submitted(kGroup);
    EXPECT_EQ(line.groups[kGroup].progress.phase(), WritePhase::writing);
    EXPECT_EQ(line.finish(), (std::vector<std::size_t>{})) << "0 was set again since: it is due";
    EXPECT_TRUE(line.groups.due(kGroup));
}

TEST(WriteGroups, ARetryKeepsWhatWasAskedForAndTheAdmission) {
    struct Case {
        const char* what;
        std::function<void(Groups&)> cause;
        bool again;  // after its commands have expired
    };
    const Case kCases[] = {
        {"set", [](Groups& line) { line.set(0, true); }, true},
        {"command", [](Groups& line) { line.command(0, true); }, false},
        {"both", [](Groups& line) { line.set(0, true), line.command(1, true); }, true},
    };
    for (const auto& c : kCases) {
        SCOPED_TRACE(c.what);
        Groups line({bit(0), bit(1)}, WriteKind::mask);
        c.cause(line);
        line.begin();
        line.groups.transaction_ended(kGroup);
        ASSERT_TRUE(line.groups.retry(line.now, kGroup, kTimeout, 3));
        EXPECT_TRUE(line.groups.due(kGroup));
        EXPECT_TRUE(line.groups[kGroup].event.admitted);
        EXPECT_TRUE(line.groups[kGroup].progress.queued());
        line.commands.end_all(line.now);
        EXPECT_EQ(line.groups.due(kGroup), c.again);
    }
}

TEST(WriteGroups, AttemptsAreCountedAndLostLinksAreNot) {
    struct Case {
        const char* what;
        OutcomeClass outcome;
        int repetitions;  // of three attempts
        bool backs_off;
    };
    const Case kCases[] = {
        {"time-out", kTimeout, 2, false},
        {"busy", kBusy, 2, true},
        {"link lost", {Reason::link_lost}, 5, false},
    };
    for (const auto& c : kCases) {
        SCOPED_TRACE(c.what);
        Groups line({word(0)});
        line.set(0, number(1));
        int repetitions = 0;
        do {
            line.begin();
            line.groups.transaction_ended(kGroup);
        } while (line.groups.retry(line.now, kGroup, c.outcome, 3) && ++repetitions < 5);
        EXPECT_EQ(repetitions, c.repetitions);
        EXPECT_EQ(line.groups[kGroup].not_before > line.now, c.backs_off);
        if (repetitions == 5) line.begin();
        line.finish(CommandResult::unknown, c.outcome.reason);
        EXPECT_EQ(line.groups[kGroup].failures, 0);
        EXPECT_EQ(line.groups[kGroup].not_before, Instant::min());
    }
}

TEST(WriteGroups, ReportsWhatWasSetSinceTheLastWrite) {
    Groups line({word(0).defaults_to(0), word(1).defaults_to(0)});
    line.set(0, number(1));
    line.begin();
    line.set(1, number(2));  // for the next write
    EXPECT_EQ(line.finish(), (std::vector<std::size_t>{0}));
    EXPECT_FALSE(line.by_trigger);
    line.begin();
    EXPECT_EQ(line.finish(), (std::vector<std::size_t>{1}));
    line.groups.pull_trigger(line.now, kGroup);
    line.begin();
    EXPECT_EQ(line.finish(), (std::vector<std::size_t>{0, 1})) << "none was set: all";
    EXPECT_TRUE(line.by_trigger);
    line.set(0, number(3));
    line.command(1, number(4));
    line.begin();
    EXPECT_EQ(line.finish(), (std::vector<std::size_t>{0})) << "the command has an outcome of its own";
    EXPECT_EQ(line.commands.take_outcome()->result, CommandResult::done);
}

TEST(WriteGroups, AVerifiedGroupIsReadBackWithItsAttempts) {
    Groups line({word(0).verified()});
    line.set(0, number(1));
    line.begin();
    line.groups.transaction_ended(kGroup);
    line.groups.await_read_back(kGroup);
    EXPECT_TRUE(line.groups[kGroup].progress.awaits_read_back());
    EXPECT_EQ(line.groups[kGroup].read_back->order, line.groups[kGroup].event.order);
    line.groups.read_back_submitted(kGroup);
    line.groups.transaction_ended(kGroup);
    EXPECT_TRUE(line.groups.read_back_again(line.now, kGroup, kBusy, 2));
    EXPECT_GT(line.groups[kGroup].read_back->not_before, line.now);
    EXPECT_FALSE(line.groups.read_back_again(line.now, kGroup, kTimeout, 2));
    EXPECT_FALSE(line.groups.read_back_again(line.now, kGroup, {Reason::link_lost}, 9));
    EXPECT_EQ(line.values.sent(0), number(1));
}

TEST(WriteGroups, OfferTheirValuesToCommandsAlone) {
    Groups line({word(0)});
    line.commands.add(line.now, {.command = {9, WriteFixture::slot(0), number(4)}, .order = 9});
    line.set(0, number(4));
    line.begin();
    EXPECT_TRUE(line.commands.at(9).carried);
}

TEST(WriteGroups, TokensAreThoseOfTheBucketOrOfTheLine) {
    Groups line({word(0)});
    EXPECT_EQ(line.groups.bucket(kGroup), nullptr);
    ASSERT_NE(line.groups.line_token(kGroup), nullptr);
    *line.groups.line_token(kGroup) = true;
    line.set(0, number(1));
    line.begin();
    line.finish();
    EXPECT_FALSE(*line.groups.line_token(kGroup)) << "the next write takes another one";
    line.groups.add(
        kGroup + 1,
        {.plan = &line.planned, .members = {0}, .event = RateLimitedEvent(model::RateLimit{1s, 1})}, true,
        false);
    EXPECT_NE(line.groups.bucket(kGroup + 1), nullptr);
    EXPECT_EQ(line.groups.line_token(kGroup + 1), nullptr);
    line.groups.ask(line.now, kGroup + 1);
    EXPECT_TRUE(line.groups.admit(line.now, kGroup + 1));
    line.groups.requeue(line.now, kGroup + 1);
    EXPECT_TRUE(line.groups.admit(line.now, kGroup + 1)) << "a repetition needs no new admission";
}

TEST(WriteGroups, ANewPlanCarriesWhatWaits) {
    Groups line({word(0), word(1).defaults_to(3)});
    line.set(0, number(1));
    const auto old = line.groups.take_groups();
    EXPECT_FALSE(line.groups.has(kGroup));
    EXPECT_FALSE(line.groups.on_change(0));
    line.groups.add(0, {.plan = &line.planned, .members = {0}}, true, false);
    line.groups.add(1, {.plan = &line.planned, .members = {1}}, true, false);
    plan::Request by_trigger = line.planned;
    by_trigger.write_trigger = 0;
    line.groups.add(2, {.plan = &by_trigger, .members = {0}}, false, true);
    EXPECT_EQ(line.groups.carry(0, old), kGroup);
    EXPECT_EQ(line.groups.carry(2, old), std::nullopt) << "written for another reason";
    EXPECT_TRUE(line.groups.due(0));
    EXPECT_FALSE(line.groups.due(2));
    EXPECT_EQ(line.groups[0].event.order, old[kGroup]->event.order);
}

TEST(WriteGroups, AnotherLineTakesOverWhatWaits) {
    for (const bool same_members : {false, true}) {
        Groups old({bit(0), bit(1)}, WriteKind::mask);
        old.set(1, true);
        Groups line({bit(0), bit(1)}, WriteKind::mask);
        line.values.take_over(1, old.values, 1);
        line.values.want(1, line.written(1, true));
        line.groups.take_over(kGroup, old.groups[kGroup], same_members);
        line.groups.take_over_member(1, old.groups, 1);
        EXPECT_TRUE(line.groups.due(kGroup));
        EXPECT_EQ(line.groups[kGroup].event.order == old.groups[kGroup].event.order, same_members);
        EXPECT_EQ(line.begin(), "16 00 07 FF FD 00 02");
    }
}

}  // namespace write_groups_test
}  // namespace takt::poll::test
