// The steps of a write, one by one.
#include "writes/write_progress.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "writes/modify_sequence.hpp"

namespace takt::poll {
namespace write_progress_test {

using Step = std::function<void(WriteProgress&)>;

const Step kBegin = [](WriteProgress& p) { p.begin(false); };
const Step kBeginWithRead = [](WriteProgress& p) { p.begin(true); };
const Step kEnded = [](WriteProgress& p) { p.transaction_ended(); };
const Step kWrite = [](WriteProgress& p) { p.write(); };
const Step kVerify = [](WriteProgress& p) { p.verify(); };
const Step kReadBack = [](WriteProgress& p) { p.read_back(); };
const Step kEnd = [](WriteProgress& p) { p.end(); };

TEST(WriteProgress, StepsLeadThroughThePhases) {
    struct Case {
        const char* what;
        std::vector<Step> steps;
        WritePhase phase;
        bool in_flight;
        bool may_start;
    };
    const Case kCases[] = {
        {"nothing begun", {}, WritePhase::queued, false, true},
        {"written", {kBegin}, WritePhase::writing, true, false},
        {"answered", {kBegin, kEnded}, WritePhase::writing, false, false},
        {"read first", {kBeginWithRead}, WritePhase::reading_old, true, false},
        {"register known", {kBeginWithRead, kEnded}, WritePhase::reading_old, false, false},
        {"second step", {kBeginWithRead, kEnded, kWrite}, WritePhase::writing, true, false},
        {"confirmed", {kBegin, kEnded, kVerify}, WritePhase::verifying, false, true},
        {"read back", {kBegin, kEnded, kVerify, kReadBack}, WritePhase::verifying, true, false},
        {"read back again", {kBegin, kEnded, kVerify, kReadBack, kEnded}, WritePhase::verifying, false, true},
        {"settled", {kBegin, kEnded, kVerify, kReadBack, kEnded, kEnd}, WritePhase::queued, false, true},
        {"repeated", {kBegin, kEnded, kEnd, kBegin}, WritePhase::writing, true, false},
        {"given up after the read", {kBeginWithRead, kEnded, kEnd}, WritePhase::queued, false, true},
    };
    for (const auto& c : kCases) {
        SCOPED_TRACE(c.what);
        WriteProgress progress;
        for (const auto& step : c.steps) step(progress);
        EXPECT_EQ(progress.phase(), c.phase);
        EXPECT_EQ(progress.in_flight(), c.in_flight);
        EXPECT_EQ(progress.may_start(), c.may_start);
        EXPECT_EQ(progress.queued(), c.phase == WritePhase::queued);
        EXPECT_EQ(progress.awaits_read_back(), c.phase == WritePhase::verifying && !c.in_flight);
    }
}

TEST(ModifySequence, IsActiveFromTheReadToTheWrite) {
    ModifySequence modify;
    EXPECT_FALSE(modify.active());
    modify.begin();
    EXPECT_TRUE(modify.active());
    EXPECT_FALSE(modify.second_step());
    modify.take_register({JobKind::command, 7, 2, {}, 0xABCD});
    ASSERT_TRUE(modify.second_step());
    EXPECT_TRUE(modify.active());
    const auto step = modify.finish();
    EXPECT_EQ(step.index, 7U);
    EXPECT_EQ(step.old, 0xABCD);
    EXPECT_FALSE(modify.active());
    EXPECT_FALSE(modify.second_step());
}

TEST(ModifySequence, AFailedReadEndsIt) {
    ModifySequence modify;
    modify.begin();
    modify.end();
    EXPECT_FALSE(modify.active());
    modify.begin();
    EXPECT_TRUE(modify.active());
}

}  // namespace write_progress_test
}  // namespace takt::poll
