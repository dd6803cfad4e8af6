// The values of service variables, from facts that are moved by hand.
#include "takt/value/service_values.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "takt/value/text.hpp"

namespace takt::value::test {
namespace service_values_test {

using namespace std::chrono_literals;

/// Facts that can be changed, and a count of the questions.
struct Facts final : ServiceFacts {
    Duration up{};
    std::uint64_t utc = 1'700'000'000;
    bool over = false;
    LineFacts line_facts;
    DeviceFacts device_facts;
    mutable std::map<std::string, int> asked;

    std::uint64_t utc_seconds() const override { return utc; }
    Duration uptime() const override { return up; }
    bool first_cycle_is_over() const override {
        ++asked["first cycle"];
        return over;
    }
    LineFacts line(std::size_t line) const override {
        ++asked["line " + std::to_string(line)];
        return line_facts;
    }
    DeviceFacts device(std::size_t line, std::size_t device) const override {
        ++asked["device " + std::to_string(line) + " " + std::to_string(device)];
        return device_facts;
    }
};

model::Project project_using(const std::vector<std::string>& names) {
    model::Project project;
    project.locals.push_back({.name = "own"});
    project.lines.resize(2);
    project.lines[0].name = "first";
    project.lines[1].name = "L";
    project.lines[1].devices.resize(2);
    project.lines[1].devices[0].name = "other";
    project.lines[1].devices[1].name = "D";
    for (const auto& name : names)
        project.locals.push_back(model::service_local(name, *model::find_service_field(name)));
    return project;
}

std::string value_of(const std::string& name, const Facts& facts) {
    const auto project = project_using({});
    const auto found = model::ServiceNames(project).find(name);
    if (!found) return "unknown";
    return format(found->field->type, false, service_value(*found, facts));
}

struct Row {
    const char* name;
    const char* value;
};

class ServiceValue : public ::testing::TestWithParam<Row> {};

TEST_P(ServiceValue, FromFacts) {
    Facts facts;
    facts.up = 3725s + 900ms;
    facts.line_facts = {
        .up = true, .load = 0.123456, .cycle = 12500us, .requests = 0x1'0000'0007, .errors = 5};
    facts.device_facts = {.state = 2,
                          .answering = true,
                          .response_time = 13593751ns,
                          .requests = 1000,
                          .errors = 60,
                          .timeouts = 40,
                          .checksum_errors = 20,
                          .exceptions = 7,
                          .outages = 3};
    EXPECT_EQ(value_of(GetParam().name, facts), GetParam().value);
}

INSTANTIATE_TEST_SUITE_P(
    Table, ServiceValue,
    ::testing::Values(Row{"system.time", "1700000000"}, Row{"system.uptime", "3725"},
                      Row{"system.line.L.up", "true"}, Row{"system.line.L.load", "12.35"},
                      Row{"system.line.L.cycle", "12.5"}, Row{"system.line.L.requests", "7"},
                      Row{"system.line.L.errors", "5"}, Row{"system.device.D.state", "2"},
                      Row{"system.device.D.answering", "true"},
                      Row{"system.device.D.response_time", "13.594"}, Row{"system.device.D.requests", "1000"},
                      Row{"system.device.D.errors", "60"}, Row{"system.device.D.timeouts", "40"},
                      Row{"system.device.D.checksum_errors", "20"}, Row{"system.device.D.exceptions", "7"},
                      Row{"system.device.D.outages", "3"}));

struct Moment {
    Duration uptime;
    bool second;
    bool minute;
};

class Pulses : public ::testing::TestWithParam<Moment> {};

TEST_P(Pulses, AreAFunctionOfTheUptime) {
    Facts facts;
    facts.up = GetParam().uptime;
    EXPECT_EQ(value_of("system.pulse_1s", facts), GetParam().second ? "true" : "false");
    EXPECT_EQ(value_of("system.pulse_1min", facts), GetParam().minute ? "true" : "false");
}

INSTANTIATE_TEST_SUITE_P(All, Pulses,
                         ::testing::Values(Moment{0s, false, false}, Moment{400ms, false, false},
                                           Moment{999ms, false, false}, Moment{1s, true, false},
                                           Moment{1499ms, true, false}, Moment{1500ms, false, false},
                                           Moment{59s, true, false}, Moment{60s, true, true},
                                           Moment{89900ms, false, true}, Moment{90s, true, false},
                                           Moment{120s, true, true}));

TEST(FirstCycle, EndsWhenEachRequestWasSentOrAfterTenSeconds) {
    Facts facts;
    EXPECT_EQ(value_of("system.first_cycle", facts), "true");
    facts.up = 9900ms;
    EXPECT_EQ(value_of("system.first_cycle", facts), "true");
    facts.over = true;
    EXPECT_EQ(value_of("system.first_cycle", facts), "false");
    facts.over = false;
    facts.up = 10s;
    EXPECT_EQ(value_of("system.first_cycle", facts), "false");
    facts.asked.clear();
    EXPECT_EQ(value_of("system.first_cycle", facts), "false");
    EXPECT_TRUE(facts.asked.empty()) << "later the requests are not looked through again";
}

std::string slots_text(std::span<const ServiceValues::Computed> computed) {
    std::string all;
    for (const auto& [slot, value] : computed) all += (all.empty() ? "" : " ") + std::to_string(slot.value);
    return all;
}

TEST(ServiceValues, ComputesOnlyWhatIsUsedAndDue) {
    const auto project =
        project_using({"system.device.D.answering", "system.line.L.load", "system.pulse_1s"});
    const ProjectSlots slots(project);
    ServiceValues values(project, slots);
    Facts facts;
    EXPECT_EQ(slots_text(values.update(facts)), "1 2 3");
    EXPECT_EQ(facts.asked, (std::map<std::string, int>{{"device 1 1", 1}, {"line 1", 1}}));
    facts.up = 100ms;
    EXPECT_EQ(slots_text(values.update(facts)), "1 2 3") << "the turn of the load";
    for (facts.up = 200ms; facts.up < 1100ms; facts.up += 100ms)
        EXPECT_EQ(slots_text(values.update(facts)), "1 3") << "counters and times once a second";
    EXPECT_EQ(slots_text(values.update(facts)), "1 2 3");
    facts.up = 2900ms;
    EXPECT_EQ(slots_text(values.update(facts)), "1 2 3") << "the thread was late";
    facts.up = 3s;
    EXPECT_EQ(slots_text(values.update(facts)), "1 3");
}

TEST(ServiceValues, TakeTurnsWithinASecond) {
    std::vector<std::string> names(40, "system.line.L.load");
    names[7] = "system.time";
    const auto project = project_using(names);
    const ProjectSlots slots(project);
    ServiceValues values(project, slots);
    Facts facts;
    EXPECT_EQ(values.update(facts).size(), 40U) << "each has a value from the start on";
    std::vector<int> computed(41);
    for (facts.up = 100ms; facts.up <= 3s; facts.up += 100ms) {
        const auto now = values.update(facts);
        EXPECT_LE(now.size(), 5U);
        for (const auto& [slot, value] : now) ++computed[slot.value];
        const bool has_time = std::ranges::find(now, SlotId{8}, &ServiceValues::Computed::slot) != now.end();
        EXPECT_EQ(has_time, facts.up % 1s == 0s) << "with the second";
    }
    for (std::size_t slot = 1; slot < computed.size(); ++slot) EXPECT_EQ(computed[slot], 3) << slot;
}

TEST(ServiceValues, AProjectWithoutThemHasNothingToDo) {
    const auto without = project_using({});
    EXPECT_TRUE(ServiceValues(without, ProjectSlots(without)).empty());
    const auto with = project_using({"system.time"});
    EXPECT_FALSE(ServiceValues(with, ProjectSlots(with)).empty());
}

TEST(ServiceValues, UpdatesFollowOneGrid) {
    EXPECT_EQ(ServiceValues::next_update(0s), 100ms);
    EXPECT_EQ(ServiceValues::next_update(99ms), 100ms);
    EXPECT_EQ(ServiceValues::next_update(100ms), 200ms);
    EXPECT_EQ(ServiceValues::next_update(1050ms), 1100ms) << "a late update does not delay the next one";
}

TEST(ServiceValues, HaveNoValueBeforeTheFirstUpdate) {
    const auto project = project_using({"system.uptime"});
    const Store store(slot_infos(project));
    const auto slot = *store.find("system.uptime");
    EXPECT_TRUE(store.info(slot).service);
    EXPECT_EQ(store[slot].quality, Quality::never_read);
    EXPECT_EQ(store[*store.find("own")].quality, Quality::good);
}

}  // namespace service_values_test
}  // namespace takt::value::test
