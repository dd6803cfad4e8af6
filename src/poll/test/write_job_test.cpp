// The steps of a write without a line: the same for a group and for a command alone.
#include "writes/write_job.hpp"

#include <gtest/gtest.h>

#include "write_fixture.hpp"
#include "writes/read_back.hpp"

namespace takt::poll::test {
namespace write_job_test {

using value::CommandResult;
using value::Reason;

constexpr std::size_t kGroup = 3;
constexpr std::size_t kDevice = 5;
constexpr std::uint64_t kOrder = 7;
constexpr OutcomeClass kTimeout{Reason::timeout};

/// A write of the value 9 to the only variable: of a group, or a command alone.
struct Written9 : WriteFixture {
    explicit Written9(bool of_group, const Item& item = int16("w", 4).read(3).write(0x06).verified(),
                      bool modifies = false)
        : WriteFixture({item}),
          commands(values, 4),
          groups(values, commands, arrivals),
          job({groups, commands, values},
              of_group ? transaction_id(JobKind::group_write, kGroup)
                       : transaction_id(JobKind::command, kOrder),
              kDevice) {
        if (of_group)
            add_group(modifies);
        else
            add_command(modifies);
    }
    void add_group(bool modifies) {
        planned.start = models[0].register_number;
        planned.quantity = 1;
        WriteGroup group{.plan = &planned,
                         .function = wire::Function::write_single_register,
                         .kind = modifies ? WriteKind::modify : WriteKind::whole,
                         .members = {0}};
        if (models[0].verify) group.read_back = std::make_unique<ReadBack>(read_back_of(models[0]));
        groups.add(kGroup, std::move(group), true, false);
        values.want(0, written(0, wanted_value()));
        groups.set(now, 0);
    }
    void add_command(bool modifies) {
        auto described = device(1, {});
        described.read_modify_write = modifies;
        PendingCommand command{.command = {1, slot(0), wanted_value()},
                               .device = kDevice,
                               .order = kOrder,
                               .before = values.wanted(0)};
        const auto as_written = written(0, wanted_value());
        command.want = values.want(0, as_written);
        command.alone = single_write_of(described, models[0], as_written).value();
        commands.add(now, std::move(command));
    }
    [[nodiscard]] value::Value wanted_value() const {
        return models[0].type == DataType::boolean ? value::Value{true} : number(9);
    }
    /// Its first transaction; its PDU.
    std::string begin() {
        const auto first = job.begin();
        return first ? hex(first->pdu()) : "error";
    }

    CommandQueue commands;
    ArrivalCounter arrivals;
    plan::Request planned;
    WriteGroups groups;
    WriteJob job;
    Instant now = at(1s);
};

class WriteJobTest : public testing::TestWithParam<bool> {
protected:
    [[nodiscard]] static bool of_group() { return GetParam(); }
};

TEST_P(WriteJobTest, IsWrittenAndReadBack) {
    Written9 line(of_group());
    EXPECT_EQ(line.job.of_group(), of_group());
    EXPECT_EQ(line.job.index(), of_group() ? kGroup : kOrder);
    EXPECT_EQ(line.job.device(), kDevice);
    EXPECT_TRUE(line.job.progress().queued());
    EXPECT_FALSE(line.job.modifies());
    EXPECT_EQ(line.begin(), "06 00 04 00 09");
    EXPECT_EQ(line.job.progress().phase(), WritePhase::writing);
    EXPECT_EQ(line.values.sent(0), number(9));
    ASSERT_EQ(line.job.written().size(), 1U);
    EXPECT_EQ(line.job.written()[0], 0U);
    line.job.transaction_ended();
    line.job.note_attempt(Execution::sent);
    ASSERT_NE(line.job.read_back(), nullptr);
    line.job.await_read_back();
    EXPECT_TRUE(line.job.progress().awaits_read_back());
    line.job.read_back_submitted();
    EXPECT_TRUE(line.job.progress().in_flight());
    line.job.transaction_ended();
    const auto settled = line.job.finish(line.now, CommandResult::done, Reason::ok);
    EXPECT_EQ(settled.variables.size(), of_group() ? 1U : 0U) << "a command has an outcome of its own";
    const auto outcome = line.commands.take_outcome();
    ASSERT_EQ(outcome.has_value(), !of_group());
    if (of_group()) return;
    EXPECT_EQ(outcome->result, CommandResult::done);
}

TEST_P(WriteJobTest, IsRepeatedWhileAttemptsAreLeft) {
    Written9 line(of_group());
    EXPECT_EQ(line.begin(), "06 00 04 00 09");
    line.job.transaction_ended();
    EXPECT_TRUE(line.job.retry(line.now, kTimeout, 2));
    EXPECT_TRUE(line.job.progress().queued());
    EXPECT_EQ(line.begin(), "06 00 04 00 09");
    line.job.transaction_ended();
    EXPECT_FALSE(line.job.retry(line.now, kTimeout, 2));
}

TEST_P(WriteJobTest, AReadBackIsRepeatedWhileAttemptsAreLeft) {
    Written9 line(of_group());
    EXPECT_EQ(line.begin(), "06 00 04 00 09");
    line.job.transaction_ended();
    line.job.await_read_back();
    EXPECT_TRUE(line.job.read_back_again(line.now, kTimeout, 2));
    EXPECT_TRUE(line.job.progress().awaits_read_back());
    EXPECT_FALSE(line.job.read_back_again(line.now, kTimeout, 2));
}

TEST_P(WriteJobTest, OnlyVariablesThatAreSafeToRepeatAreRepeated) {
    for (const bool safe : {false, true}) {
        auto item = int16("w", 4).read(3).write(0x06);
        if (safe) item = item.repeatable();
        Written9 line(of_group(), item);
        EXPECT_EQ(line.job.repeatable(line.job.members()), safe);
        EXPECT_EQ(line.job.read_back(), nullptr) << "it is not verified";
    }
}

TEST(WriteJob, AGroupIsRepeatedOnlyIfAllItsVariablesAreSafe) {
    const Item items[] = {int16("a", 0).write(0x10).repeatable(), int16("b", 1).write(0x10)};
    WriteFixture line({items[0], items[1]});
    CommandQueue commands(line.values, 4);
    ArrivalCounter arrivals;
    WriteGroups groups(line.values, commands, arrivals);
    const WriteJob job({groups, commands, line.values}, transaction_id(JobKind::group_write, 0), 0);
    const std::size_t kBoth[] = {0, 1};
    EXPECT_TRUE(job.repeatable({kBoth, 1}));
    EXPECT_FALSE(job.repeatable(kBoth));
}

TEST(WriteJob, AfterAnAttemptThatMayHaveExecutedARefusalIsUnknown) {
    for (const bool differs : {false, true}) {
        Written9 line(false);
        EXPECT_EQ(line.begin(), "06 00 04 00 09");
        line.job.transaction_ended();
        if (differs)
            line.job.note_differs();
        else
            line.job.note_attempt(Execution::possible);
        line.job.note_attempt(Execution::sent);
        line.job.finish(line.now, CommandResult::refused, Reason::ok);
        EXPECT_EQ(line.commands.take_outcome()->result, CommandResult::unknown) << differs;
    }
}

TEST_P(WriteJobTest, ReadModifyWriteHasTwoSteps) {
    Written9 line(of_group(), boolean("b", 7, 2).read(3).write(0x06), true);
    ASSERT_TRUE(line.job.modifies());
    EXPECT_EQ(line.begin(), "03 00 07 00 01");
    EXPECT_EQ(line.job.progress().phase(), WritePhase::reading_old);
    line.job.transaction_ended();
    const auto second = line.job.second_step(line.now, 0x0001);
    ASSERT_TRUE(second);
    EXPECT_EQ(hex(second->pdu()), "06 00 07 00 05");
    EXPECT_EQ(line.job.function(), wire::Function::write_single_register);
    line.job.second_step_submitted();
    EXPECT_EQ(line.job.progress().phase(), WritePhase::writing);
    line.job.requeue(line.now);
    EXPECT_TRUE(line.job.progress().queued());
}

TEST_P(WriteJobTest, WithoutABucketItTakesTheTokenOfTheLine) {
    Written9 line(of_group());
    bool* const taken = line.job.line_token();
    ASSERT_NE(taken, nullptr);
    EXPECT_FALSE(*taken);
    *taken = true;
    EXPECT_TRUE(*line.job.line_token());
}

INSTANTIATE_TEST_SUITE_P(Kinds, WriteJobTest, testing::Bool(),
                         [](const auto& kind) { return kind.param ? "Group" : "Command"; });

}  // namespace write_job_test
}  // namespace takt::poll::test
