// A plan with its proof, and a project with the measures that change only its plan.
#include "takt/plan/proof.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "golden_project.hpp"
#include "takt/plan/applied_measures.hpp"

namespace takt::plan {
namespace proof_test {

using namespace test;

model::Project golden_project(std::size_t index) {
    return project_of(golden::sets()[index]);
}

TEST(Proof, HasThePlanItsBoundsAndFindings) {
    const auto proof = prove(golden_project(1), true, false);
    ASSERT_EQ(proof.plan.lines.size(), 1U);
    ASSERT_EQ(proof.lines.size(), 1U);
    EXPECT_FALSE(proof.lines[0].feasible);
    EXPECT_TRUE(proof.has_errors());
    EXPECT_TRUE(proof.measures.found.empty()) << "not asked for";
    EXPECT_FALSE(prove(golden_project(1), true, true).measures.found.empty());
}

TEST(Proof, UsesAPlanThatWasMadeAlready) {
    const auto project = golden_project(2);
    auto plan = make_plan(project);
    const auto* const lines = plan.lines.data();
    double last = 0;
    const auto proof = prove(
        project, true, true,
        [&](std::size_t done, std::size_t total) {
            last = static_cast<double>(done) / static_cast<double>(total);
        },
        std::move(plan));
    EXPECT_EQ(proof.plan.lines.data(), lines) << "no other plan was made";
    EXPECT_FALSE(proof.plan.lines[0].ages.empty());
    EXPECT_TRUE(proof.lines[0].feasible);
    EXPECT_EQ(last, 1);
}

TEST(Proof, AFeasibleProjectHasNoErrors) {
    const auto proof = prove(golden_project(2), true, true);
    EXPECT_TRUE(proof.lines[0].feasible);
    EXPECT_FALSE(proof.has_errors());
}

TEST(AppliedMeasures, TheFirstMeasureOfThePlanMakesTheLineFeasible) {
    const auto project = golden_project(1);
    const auto proof = prove(project, false, true);
    const auto applied = apply_measures(project, proof, false);
    EXPECT_TRUE(applied.not_helped.empty());
    ASSERT_EQ(applied.changes.size(), 1U);
    EXPECT_EQ(applied.changes[0].key, "registers_per_request");
    EXPECT_TRUE(applied.proof.lines[0].feasible);
    EXPECT_TRUE(applied.proof.measures.found.empty());
}

TEST(Proof, TheProgressGrowsToItsEnd) {
    auto project = golden_project(1);
    project.lines.push_back(project.lines[0]);
    for (const bool with_measures : {false, true}) {
        double last = 0;
        std::size_t reports = 0;
        (void)prove(project, true, with_measures, [&](std::size_t done, std::size_t total) {
            const double share = static_cast<double>(done) / static_cast<double>(total);
            EXPECT_GE(share, last);
            last = share;
            ++reports;
        });
        EXPECT_EQ(last, 1);
        EXPECT_GE(reports, with_measures ? 8U : 4U);
    }
}

TEST(AppliedMeasures, AFeasibleProjectStaysAsItIs) {
    const auto project = golden_project(2);
    const auto proof = prove(project, false, true);
    const auto applied = apply_measures(project, proof, false);
    EXPECT_TRUE(applied.changes.empty());
    EXPECT_TRUE(applied.not_helped.empty());
}

TEST(AppliedMeasures, ALineThatOnlyAHigherBitRateHelpsIsNotHelped) {
    const auto project = golden_project(4);
    auto proof = prove(project, false, true);
    std::erase_if(proof.measures.found, [](const Measure& measure) { return measure.only_plan(); });
    const auto applied = apply_measures(project, proof, false);
    EXPECT_EQ(applied.not_helped, std::vector<std::size_t>{0});
    EXPECT_TRUE(applied.changes.empty());
    EXPECT_EQ(applied.project.lines[0].format.baud, project.lines[0].format.baud);
}

TEST(AppliedMeasures, AKeyThatTwoLinesChangeIsListedOnce) {
    auto project = golden_project(1);
    project.lines.push_back(project.lines[0]);
    auto proof = prove(project, false, true);
    const Change shared{"", "", "derive_timeouts", "false", "true"};
    for (auto& measure : proof.measures.found) measure.changes = {shared};
    const auto applied = apply_measures(project, proof, false);
    EXPECT_EQ(applied.changes.size(), 1U);
}

}  // namespace proof_test
}  // namespace takt::plan
