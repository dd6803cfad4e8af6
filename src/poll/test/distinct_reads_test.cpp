// Which reads a line sends in the place of planned ones, without a line.
#include "reads/distinct_reads.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"
#include "line/transfer.hpp"

namespace takt::poll::test {
namespace distinct_reads_test {

using bus::Ambiguity;
using Ended = DistinctReads::Ended;
using Kind = plan::ReadAlternative::Kind;

constexpr OutcomeClass kOk{.reason = value::Reason::ok, .answered = true};
constexpr OutcomeClass kRefused{.reason = value::exception_reason(2), .answered = true};
constexpr OutcomeClass kTimeout{.reason = value::Reason::timeout};

/// One device with one planned read of the registers 0..3. Nothing else may be read: there are parts only.
struct Line {
    Line()
        : described(project({device(1, {int16("a", 0).read(3), int16("b", 1).read(3), int16("c", 2).read(3),
                                        int16("d", 3).read(3)})})),
          plan(plan::make_plan(described)),
          reads(described, described.lines[0], {variables, devices, requests}) {
        devices.resize(1);
        devices[0].model = &described.lines[0].devices[0];
        requests.resize(1);
        requests[0].plan = &plan.lines[0].requests[0];
        reads.set_requests(plan.lines[0].requests);
    }
    /// The planned read is ambiguous, all others are not.
    const plan::ReadAlternative* send() {
        const auto* instead =
            reads.choose(0, Ambiguity::held, [](wire::Function, std::uint16_t) { return Ambiguity::none; });
        reads.send(0, instead);
        return instead;
    }

    model::Project described;
    plan::Plan plan;
    std::vector<VariableRun> variables;
    std::vector<DeviceRun> devices;
    std::vector<RequestRun> requests;
    DistinctReads reads;
};

TEST(DistinctReads, WithoutAnAlternativeEachEndIsThatOfThePlannedRead) {
    Line line;
    ASSERT_EQ(line.plan.lines[0].requests.size(), 1U);
    EXPECT_TRUE(line.reads.whole(0));
    line.reads.send(0, nullptr);
    EXPECT_EQ(line.reads.ended(0, kOk), Ended::planned);
    EXPECT_EQ(line.reads.ended(0, kRefused), Ended::planned);
}

TEST(DistinctReads, APartHasSomeValuesAndIsReadOnce) {
    Line line;
    const auto* part = line.send();
    ASSERT_TRUE(part && part->kind == Kind::part);
    EXPECT_LT(part->quantity, 4);
    EXPECT_FALSE(line.reads.whole(0));
    EXPECT_EQ(line.reads.ended(0, kTimeout), Ended::planned) << "no response";
    EXPECT_EQ(line.reads.ended(0, kOk), Ended::part);
    EXPECT_EQ(line.send(), nullptr) << "the planned read follows";
    EXPECT_EQ(line.reads.ended(0, kOk), Ended::planned);
    EXPECT_NE(line.send(), nullptr);
}

TEST(DistinctReads, WhatTheDeviceRefusesIsNotSentAgain) {
    Line line;
    const auto* first = line.send();
    ASSERT_NE(first, nullptr);
    const auto refused = *first;
    EXPECT_EQ(line.reads.ended(0, kRefused), Ended::other);
    const auto* second = line.send();
    EXPECT_TRUE(!second || *second != refused);
}

TEST(DistinctReads, ANewPlanForgetsTheAlternatives) {
    Line line;
    ASSERT_NE(line.send(), nullptr);
    EXPECT_EQ(line.reads.ended(0, kOk), Ended::part);
    line.reads.set_requests(line.plan.lines[0].requests);
    EXPECT_TRUE(line.reads.whole(0));
    EXPECT_NE(line.send(), nullptr) << "its part may be sent again";
}

}  // namespace distinct_reads_test
}  // namespace takt::poll::test
