// Commands without a line: what ends them, and with which outcome.
#include "writes/command_queue.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <optional>

#include "write_fixture.hpp"

namespace takt::poll::test {
namespace command_queue_test {

using value::CommandResult;
using value::Reason;
using value::Value;

constexpr std::size_t kGroup = 4;
constexpr std::size_t kCapacity = 8;

/// Three variables: 0 and 1 on device 0, 2 on device 1.
class Queue : public WriteFixture {
public:
    Queue()
        : WriteFixture({int16("a", 0).read(3).write(0x06), int16("b", 1).read(3).write(0x06),
                        int16("c", 0).read(3).write(0x06)}),
          queue(values, kCapacity) {}

    /// A command arrives; its id is its order.
    std::uint64_t add(std::size_t variable, std::int64_t value, std::optional<std::size_t> group = {},
                      Instant expires = kNever) {
        const std::uint64_t order = ++last_;
        PendingCommand command{.command = {order, slot(variable), number(value), expires},
                               .variable = variable,
                               .device = variable == 2 ? 1U : 0U,
                               .order = order,
                               .group = group,
                               .before = values.wanted(variable)};
        command.want = values.want(variable, written(variable, number(value)));
        queue.add(now, std::move(command));
        return order;
    }
    void set(std::size_t variable, std::int64_t value) {
        values.want(variable, written(variable, number(value)));
        queue.supersede(now, variable, number(value));
    }
    /// The next outcome: whose, and how it ended.
    std::string next() {
        const auto outcome = queue.take_outcome();
        if (!outcome) return "none";
        return std::to_string(outcome->id) + " " + std::string(name(outcome->result)) + " " +
               std::string(name(outcome->reason));
    }

    CommandQueue queue;
    Instant now = at(1s);

private:
    std::uint64_t last_ = 0;
};

std::string ended(std::uint64_t id, CommandResult result, Reason reason = Reason::ok) {
    return std::to_string(id) + " " + std::string(name(result)) + " " + std::string(name(reason));
}

TEST(CommandQueue, IsBoundedByCommandsAndOutcomes) {
    Queue line;
    for (std::size_t i = 0; i < kCapacity; ++i) {
        EXPECT_FALSE(line.queue.full());
        line.add(0, 1);
    }
    EXPECT_TRUE(line.queue.full());
    line.queue.finish(line.now, 1, CommandResult::done, Reason::ok);
    EXPECT_TRUE(line.queue.full()) << "its outcome was not taken";
    EXPECT_EQ(line.next(), ended(1, CommandResult::done));
    EXPECT_FALSE(line.queue.full());
}

/// Ends of a command that waits, after what attempts left behind.
TEST(CommandQueue, WhatEndsAWaitingCommand) {
    struct End {
        const char* what;
        std::function<void(Queue&)> end;
        CommandResult unsent;
        Reason reason;
    };
    const End kEnds[] = {
        {"expiry", [](Queue& line) { line.queue.expire(at(5s)); }, CommandResult::expired, Reason::ok},
        {"device", [](Queue& line) { line.queue.drop_waiting(at(5s), 0, Reason::switched_off); },
         CommandResult::refused, Reason::switched_off},
        {"end of the run", [](Queue& line) { line.queue.end_all(at(5s)); }, CommandResult::expired,
         Reason::ok},
    };
    struct History {
        const char* what;
        Execution execution;
        bool carried;
        bool known;
    };
    const History kHistories[] = {
        {"never sent", Execution::not_sent, false, true},
        {"sent", Execution::sent, false, false},
        {"perhaps executed", Execution::possible, false, false},
        {"carried by a group", Execution::not_sent, true, false},
    };
    for (const auto& end : kEnds)
        for (const auto& history : kHistories) {
            SCOPED_TRACE(std::string(end.what) + ", " + history.what);
            Queue line;
            line.set(0, 3);
            const auto order = line.add(0, 7, std::nullopt, at(5s));
            line.queue.at(order).execution = history.execution;
            if (history.carried) line.queue.carry(0, number(7));
            end.end(line);
            EXPECT_EQ(line.next(),
                      ended(order, history.known ? end.unsent : CommandResult::unknown, end.reason));
            EXPECT_TRUE(line.queue.empty());
            EXPECT_EQ(line.wanted(0), number(history.known ? 3 : 7));
        }
}

TEST(CommandQueue, ACommandThatIsBeingWrittenNeitherExpiresNorIsDropped) {
    Queue line;
    const auto order = line.add(0, 7, std::nullopt, at(2s));
    EXPECT_EQ(line.queue.next_expiry(), at(2s));
    line.queue.at(order).progress.begin(false);
    EXPECT_EQ(line.queue.next_expiry(), kNever);
    line.queue.expire(at(9s));
    line.queue.drop_waiting(at(9s), 0, Reason::not_answering);
    EXPECT_FALSE(line.queue.drop_read_backs(at(9s), 0, Reason::not_answering));
    EXPECT_EQ(line.next(), "none");
    line.queue.end_all(at(9s));
    EXPECT_EQ(line.next(), ended(order, CommandResult::unknown));
}

TEST(CommandQueue, OnlyCommandsOfTheDeviceAreDropped) {
    Queue line;
    line.add(0, 7);
    line.add(2, 7);
    line.queue.drop_waiting(line.now, 1, Reason::not_answering);
    EXPECT_EQ(line.next(), ended(2, CommandResult::refused, Reason::not_answering));
    EXPECT_EQ(line.next(), "none");
    EXPECT_NE(line.queue.find(1), nullptr);
    EXPECT_EQ(line.queue.find(2), nullptr);
}

TEST(CommandQueue, AConfirmedWriteThatIsNotComparedIsUnknown) {
    Queue line;
    const auto order = line.add(2, 7);
    auto& progress = line.queue.at(order).progress;
    progress.begin(false);
    progress.transaction_ended();
    progress.verify();
    EXPECT_FALSE(line.queue.drop_read_backs(line.now, 0, Reason::link_lost)) << "another device";
    EXPECT_TRUE(line.queue.drop_read_backs(line.now, 1, Reason::link_lost));
    EXPECT_EQ(line.next(), ended(order, CommandResult::unknown, Reason::link_lost));
}

// Only what can be sent now is offered: in the order of arrival, without those of groups.
TEST(CommandQueue, OffersCommandsAloneThatMayStart) {
    Queue line;
    for (int i = 0; i < 4; ++i) line.add(0, 7);
    line.add(1, 7, kGroup);
    line.queue.at(1).progress.begin(false);
    auto& verified = line.queue.at(2).progress;
    verified.begin(false);
    verified.transaction_ended();
    verified.verify();
    std::vector<std::uint64_t> offered;
    line.queue.for_each_startable([&](const PendingCommand& c) { offered.push_back(c.order); });
    EXPECT_EQ(offered, (std::vector<std::uint64_t>{2, 3, 4}));
}

TEST(CommandQueue, ARefusalProvesNothingAboutEarlierAttempts) {
    struct Case {
        Execution execution;
        Reason reason;
        CommandResult result;
    };
    const Case kCases[] = {
        {Execution::not_sent, Reason::timeout, CommandResult::refused},
        {Execution::sent, value::exception_reason(3), CommandResult::refused},
        {Execution::possible, value::exception_reason(3), CommandResult::unknown},
        {Execution::possible, Reason::differs, CommandResult::refused},  // it was read back
    };
    for (const auto& c : kCases) {
        Queue line;
        const auto order = line.add(0, 7);
        line.queue.at(order).execution = c.execution;
        line.queue.finish(line.now, order, CommandResult::refused, c.reason);
        EXPECT_EQ(line.next(), ended(order, c.result, c.reason));
    }
}

TEST(CommandQueue, ADifferenceShowsBothValues) {
    Queue line;
    const auto order = line.add(0, 7);
    line.queue.at(order).progress.begin(false);
    line.queue.note_read_back(0, number(8));
    line.queue.finish(line.now, order, CommandResult::refused, Reason::differs);
    const auto outcome = line.queue.take_outcome();
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->written, number(7));
    EXPECT_EQ(outcome->read_back, number(8));
}

// ---- what is wanted after commands that were not executed

TEST(CommandQueue, ExpiredCommandsRestoreTheValueBeforeAllOfThem) {
    for (const bool second_first : {false, true}) {
        Queue line;
        line.set(0, 1);
        line.add(0, 2, std::nullopt, at(second_first ? 6s : 5s));
        line.add(0, 3, std::nullopt, at(second_first ? 5s : 6s));
        line.queue.expire(at(5s));
        EXPECT_EQ(line.wanted(0), number(second_first ? 2 : 3));
        line.queue.expire(at(6s));
        EXPECT_EQ(line.wanted(0), number(1));
    }
}

TEST(CommandQueue, AValueThatWasSetSinceStays) {
    Queue line;
    line.add(0, 2, std::nullopt, at(5s));
    line.set(0, 2);
    line.queue.expire(at(5s));
    EXPECT_EQ(line.wanted(0), number(2));
}

// ---- groups

TEST(CommandQueue, ANewerValueSupersedesCommandsThatWaitForTheirGroup) {
    Queue line;
    line.add(0, 1, kGroup);
    line.add(0, 2);  // alone: it is sent all the same
    line.add(1, 1, kGroup);
    EXPECT_EQ(line.queue.waiting(kGroup), 1U) << "2 is newer than 1";
    EXPECT_EQ(line.next(), ended(1, CommandResult::refused, Reason::superseded));
    line.set(1, 1);
    EXPECT_EQ(line.next(), "none") << "the same value";
    line.set(1, 5);
    EXPECT_EQ(line.next(), ended(3, CommandResult::refused, Reason::superseded));
    EXPECT_EQ(line.queue.waiting(kGroup), 0U);
    EXPECT_NE(line.queue.find(2), nullptr);
}

TEST(CommandQueue, AGroupIsWrittenForAllThatWaitForIt) {
    Queue line;
    line.add(0, 1, kGroup);
    line.add(1, 2, kGroup);
    line.add(2, 3, kGroup + 1);
    EXPECT_TRUE(line.queue.waits_for_group(0));
    line.queue.begin_group(kGroup);
    EXPECT_EQ(line.queue.waiting(kGroup), 0U);
    EXPECT_EQ(line.queue.waiting(kGroup + 1), 1U);
    EXPECT_FALSE(line.queue.waits_for_group(0));
    EXPECT_TRUE(line.queue.begun(kGroup, 0));
    EXPECT_FALSE(line.queue.begun(kGroup, 2));
    line.add(0, 4, kGroup);  // for the next write of the group
    line.queue.finish_group(line.now, kGroup, CommandResult::done, Reason::ok);
    EXPECT_EQ(line.next(), ended(1, CommandResult::done));
    EXPECT_EQ(line.next(), ended(2, CommandResult::done));
    EXPECT_EQ(line.next(), "none");
    EXPECT_EQ(line.queue.waiting(kGroup), 1U);
}

TEST(CommandQueue, ARepeatedGroupIsWrittenForWhatIsStillWanted) {
    Queue line;
    line.add(0, 1, kGroup);
    line.add(1, 2, kGroup);
    line.queue.begin_group(kGroup);
    line.queue.note_attempt(kGroup, Execution::possible);
    line.set(0, 9);
    line.queue.requeue_group(line.now, kGroup);
    EXPECT_EQ(line.next(), ended(1, CommandResult::unknown, Reason::superseded));
    EXPECT_EQ(line.queue.waiting(kGroup), 1U);
    line.queue.drop_waiting(line.now, 0, Reason::not_answering);
    EXPECT_EQ(line.next(), ended(2, CommandResult::unknown, Reason::not_answering));
    EXPECT_EQ(line.queue.waiting(kGroup), 0U);
}

TEST(CommandQueue, AttemptsNeverBecomeLessThanTheyWere) {
    Queue line;
    line.add(0, 1, kGroup);
    line.queue.begin_group(kGroup);
    line.queue.note_attempt(kGroup, Execution::possible);
    line.queue.note_attempt(kGroup, Execution::not_sent);
    EXPECT_EQ(line.queue.at(1).execution, Execution::possible);
}

TEST(CommandQueue, MembersThatReadBackEqualAreDoneThoughTheGroupDiffers) {
    Queue line;
    line.add(0, 1, kGroup);
    line.add(1, 2, kGroup);
    line.queue.begin_group(kGroup);
    line.queue.note_read_back(0, Value{});
    line.queue.note_read_back(1, number(3));
    line.queue.note_differs(kGroup);
    line.queue.finish_group(line.now, kGroup, CommandResult::refused, Reason::differs);
    EXPECT_EQ(line.next(), ended(1, CommandResult::done));
    EXPECT_EQ(line.next(), ended(2, CommandResult::refused, Reason::differs));
}

TEST(CommandQueue, AConfirmedMemberThatWasSetSinceIsDone) {
    Queue line;
    line.add(0, 1, kGroup);
    line.add(1, 2, kGroup);
    line.queue.begin_group(kGroup);
    line.queue.note_read_back(0, Value{});
    line.queue.note_read_back(1, number(3));
    line.queue.note_differs(kGroup);
    line.set(0, 5);
    line.set(1, 5);
    line.queue.refuse_outdated(line.now, kGroup);
    EXPECT_EQ(line.next(), ended(1, CommandResult::done));
    EXPECT_EQ(line.next(), ended(2, CommandResult::unknown, Reason::superseded));
}

TEST(CommandQueue, CommandsFollowTheirVariableToAnotherGroup) {
    Queue line;
    line.add(0, 1, kGroup);
    line.add(1, 2, kGroup);
    line.queue.begin_group(kGroup);
    line.add(0, 1, kGroup);
    line.queue.regroup([](PendingCommand& command) { command.group = 1; });
    EXPECT_EQ(line.queue.waiting(kGroup), 0U);
    EXPECT_EQ(line.queue.waiting(1), 1U);
}

// ---- values that a group carries

TEST(CommandQueue, AGroupCarriesTheValueOfACommandAlone) {
    struct Case {
        std::int64_t value;  // written by the group
        std::size_t device;  // whose write ended
        bool sent;
        Execution execution;
    };
    const Case kCases[] = {{7, 0, true, Execution::possible},
                           {7, 0, false, Execution::not_sent},
                           {8, 0, true, Execution::not_sent},
                           {7, 1, true, Execution::not_sent}};
    for (const auto& c : kCases) {
        Queue line;
        const auto order = line.add(0, 7);
        line.queue.carry(0, number(c.value));
        line.queue.end_carry(c.device, c.sent);
        EXPECT_EQ(line.queue.at(order).execution, c.execution);
        line.queue.end_carry(c.device, true);
        EXPECT_EQ(line.queue.at(order).execution, c.execution) << "it ends once";
    }
}

}  // namespace command_queue_test
}  // namespace takt::poll::test
