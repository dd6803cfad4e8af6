// Each advice of a finding, followed literally, removes the finding.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <functional>
#include <set>

#include "golden_project.hpp"
#include "takt/plan/guarantee_findings.hpp"
#include "takt/plan/proof.hpp"

namespace takt::plan {
namespace remedies_test {

using namespace test;

std::set<std::string> codes_of(const model::Project& project) {
    std::set<std::string> codes;
    for (const auto& finding : prove(project, false, false).findings) codes.insert(finding.code);
    return codes;
}

// Measures
// --------------------------------------------------------------------------------------------------------

model::Device random_device(int address) {
    const auto strategy =
        *rc::gen::element(model::Strategy::single, model::Strategy::classic, model::Strategy::optimal);
    const auto periods =
        *rc::gen::resize(12, rc::gen::nonEmpty(rc::gen::container<std::vector<Duration>>(
                                 rc::gen::element<Duration>(0ms, 20ms, 50ms, 80ms, 120ms, 1s, 3s))));
    std::vector<Item> items;
    for (std::size_t i = 0; i < periods.size(); ++i) {
        items.push_back(int16(static_cast<int>((i % 3 + 1) * i)).read(3).every(periods[i]));
        if (*rc::gen::inRange(0, 12) == 0) items.back().deadline = periods[i] / 2 + 30ms;
    }
    auto made = device(address, {.strategy = strategy}, items);
    made.response_timeout = *rc::gen::element<Duration>(20ms, 100ms, 500ms);
    made.response_timeout_set = *rc::gen::arbitrary<bool>();
    made.attempts = *rc::gen::element<std::uint16_t>(1, 3, 10);
    if (*rc::gen::inRange(0, 4) > 0) made.turnaround = *rc::gen::element<Duration>(1ms, 5ms, 20ms);
    return made;
}

model::Project random_project() {
    auto made = project({}, {});
    made.faults_set = *rc::gen::arbitrary<bool>();
    made.derive_timeouts = *rc::gen::arbitrary<bool>();
    auto& line = made.lines[0];
    line.format.baud = *rc::gen::element(2400U, 9600U, 19200U);
    line.devices.clear();
    const int devices = *rc::gen::inRange(1, 4);
    for (int address = 1; address <= devices; ++address) line.devices.push_back(random_device(address));
    if (*rc::gen::inRange(0, 3) == 0) line.relayed = model::SharedLine{.response_timeout = 100ms};
    if (*rc::gen::inRange(0, 3) == 0) made.lines.push_back(line);
    return made;
}

/// The codes that a line of this goal must not have.
std::set<std::string> removed_by(Goal goal, const model::Project& project) {
    std::set<std::string> codes{"guarantee.late", "guarantee.unbounded", "guarantee.overload",
                                "guarantee.overload_grouped"};
    if (goal != Goal::sound || !project.faults_set) codes.insert("guarantee.response_unknown");
    if (goal != Goal::sound) codes.insert("guarantee.late_with_fault");
    if (goal == Goal::with_dead_device) codes.insert("guarantee.late_with_dead");
    return codes;
}

RC_GTEST_PROP(Remedies, EachMeasureRemovesItsFindings, ()) {
    const auto project = random_project();
    const auto proof = prove(project, false, true);
    RC_CLASSIFY(!proof.measures.found.empty());
    for (const Measure& measure : proof.measures.found) {
        auto changed = project;
        measure.apply(changed);
        const auto after = prove(changed, false, false);
        RC_ASSERT(after.lines[measure.line].feasible);
        RC_ASSERT(after.lines[measure.line].utilization == measure.utilization_after);
        const auto path = "lines[" + std::to_string(measure.line) + "]";
        const auto removed = removed_by(measure.goal, project);
        for (const auto& finding : after.findings)
            RC_ASSERT(!finding.path.starts_with(path) || !removed.contains(finding.code));
        RC_ASSERT(!measure.changes.empty());
    }
}

// What the advices of the findings name
// --------------------------------------------------------------------------------------------------------

model::Variable& first_variable(model::Project& project) {
    return project.lines[0].devices[0].variables[0];
}

model::Device& first_device(model::Project& project) {
    return project.lines[0].devices[0];
}

/// The fast loop behind a long read: late by 18 ms.
model::Project blocked() {
    return project_of(golden::sets()[1]);
}

/// One request that takes longer than its period.
model::Project overloaded() {
    auto made = project({}, {int16(0).read(3).every(4ms)});
    first_device(made).turnaround = 5ms;
    return made;
}

model::Project ungrouped() {
    auto made = project({.strategy = model::Strategy::single}, row(16, int16(0).read(3).every(100ms)));
    first_device(made).turnaround = 5ms;
    return made;
}

model::Project without_turnaround() {
    auto made = project({}, {int16(0).read(3).every(100ms)});
    first_device(made).response_timeout = 500ms;
    return made;
}

model::Project of_a_controller() {
    auto made = without_turnaround();
    made.profile = model::Profile::owen_kc1;
    return made;
}

model::Project learning() {
    auto made = without_turnaround();
    for (auto& device : made.lines[0].devices) device.learn_turnaround = true;
    return made;
}

model::Project measured() {
    auto made = without_turnaround();
    auto& device = first_device(made);
    device.learn_turnaround = true;
    device.times.measured = {.exchanges = 3120, .longest = 8ms, .p999 = 7ms};
    return made;
}

model::Project faulty() {
    auto made = project_of(golden::sets()[3]);
    made.derive_timeouts = false;
    made.faults_set = true;
    return made;
}

/// A dead device costs 30 time-outs.
model::Project stubborn() {
    auto made = project_of(golden::sets()[2]);
    made.lines[0].devices[1].attempts = 30;
    return made;
}

/// A dead device costs a time-out of 500 ms.
model::Project patient() {
    auto made = project({}, {int16(0).read(3).every(100ms)});
    made.lines[0].devices.push_back(device(17, {}, {int16(0).read(3).every(100ms)}));
    for (auto& device : made.lines[0].devices) {
        device.turnaround = 5ms;
        device.attempts = 1;
        device.response_timeout = 500ms;
        device.response_timeout_set = true;
    }
    return made;
}

struct Advice {
    const char* code;
    const char* action;
    model::Project project;
    std::function<void(model::Project&)> follow;
};

std::vector<Advice> advices() {
    const auto each_device = [](auto change) {
        return [change](model::Project& project) {
            for (auto& device : project.lines[0].devices) change(device);
        };
    };
    auto on_change = project({}, {int16(0).write(0x10).on_change()});
    return {
        {"guarantee.late", "a longer period", blocked(),
         [](model::Project& project) {
             for (auto& variable : project.lines[0].devices[1].variables) variable.period = 200ms;
         }},
        {"guarantee.late", "a longer deadline", blocked(),
         [](model::Project& project) {
             for (auto& variable : project.lines[0].devices[1].variables) variable.deadline = 120ms;
         }},
        {"guarantee.overload", "group_requests: true", ungrouped(), each_device([](model::Device& device) {
             device.group_requests = true;
             device.strategy = model::Strategy::optimal;
         })},
        {"guarantee.overload_grouped", "a longer period of the largest share", overloaded(),
         [](model::Project& project) { first_variable(project).period = 40ms; }},
        {"guarantee.late_with_fault", "derive_timeouts: true", faulty(),
         [](model::Project& project) { project.derive_timeouts = true; }},
        {"guarantee.late_with_dead", "fewer attempts", stubborn(),
         each_device([](model::Device& device) { device.attempts = 1; })},
        {"guarantee.late_with_dead", "a shorter time-out", patient(),
         each_device([](model::Device& device) { device.response_timeout = 10ms; })},
        {"guarantee.response_unknown", "turnaround", without_turnaround(),
         [](model::Project& project) { first_device(project).turnaround = 20ms; }},
        {"guarantee.response_not_learnt", "turnaround", of_a_controller(),
         [](model::Project& project) { first_device(project).turnaround = 20ms; }},
        {"guarantee.response_learning", "a run", learning(),
         [](model::Project& project) {
             first_device(project).times.measured = {.exchanges = 3120, .longest = 10ms, .p999 = 9ms};
         }},
        {"guarantee.response_measured", "turnaround", measured(),
         [](model::Project& project) { first_device(project).turnaround = 20ms; }},
        {"guarantee.unlimited", "min_interval", on_change,
         [](model::Project& project) {
             first_variable(project).admission = model::RateLimit{.min_interval = 1s, .burst = 1};
         }},
    };
}

TEST(Remedies, EachAdviceRemovesItsFinding) {
    for (auto& [code, action, project, follow] : advices()) {
        EXPECT_TRUE(codes_of(project).contains(code)) << code;
        follow(project);
        const auto left = codes_of(project);
        EXPECT_FALSE(left.contains(code)) << code << ": " << action;
        EXPECT_FALSE(left.contains("guarantee.unbounded")) << code << ": " << action;
    }
}

// Codes whose advice is a measure, or more than one action, are left to the property above.
TEST(Remedies, EveryAdviceIsFollowed) {
    std::set<std::string_view> followed{"guarantee.unbounded", "guarantee.more", "guarantee.rough"};
    for (const auto& advice : advices()) followed.insert(advice.code);
    for (const auto code : guarantee_finding_codes()) EXPECT_TRUE(followed.contains(code)) << code;
}

}  // namespace remedies_test
}  // namespace takt::plan
