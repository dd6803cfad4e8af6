#include "live/why.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "running_host.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::web {
namespace why_test {

using namespace test;

const std::string kProject = host::test::project_with(
    host::test::line_of(
        "plant",
        host::test::device_of("Boiler", 1,
                              host::test::variable_of("Level", 0) +
                                  host::test::variable_of("Asked", 9, ", read_trigger: go") +
                                  "          - {name: Command, type: int, register: 20, write: 0x06}\n",
                              ", poll_enable: enabled")),
    "- {name: go, type: bool}\n- {name: enabled, type: bool, default: true}\n");

/// A state of the project, to be changed by a case.
host::Snapshot state() {
    RunningHost running(kProject);
    const auto session = running.host->open_session({.events = false});
    auto snapshot = *(*session)->snapshot({.values = true, .statistics = true, .plan = true});
    auto& line = snapshot.lines[0];
    line.up = line.was_up = true;
    line.why.reset();
    line.statistics = {};
    line.devices[0] = {};
    line.devices[0].state = poll::DeviceState::answering;
    for (auto& its : line.variables) {
        its = {};
        its.recent_period = std::chrono::milliseconds(100);
    }
    for (auto& its : snapshot.values) its.reason = value::Reason::ok;
    return snapshot;
}

std::vector<std::string> codes(const host::Snapshot& snapshot, const std::string& name) {
    std::vector<std::string> result;
    for (const auto& hop :
         why(report::Texts(text::Language::english), snapshot, *snapshot.configuration->find(name)))
        result.push_back(std::string(hop.text.substr(8)) + (hop.state == WhyHop::State::ok     ? ""
                                                            : hop.state == WhyHop::State::wait ? "?"
                                                                                               : "!"));
    return result;
}

using Codes = std::vector<std::string>;

TEST(Why, NamesTheHopThatKeepsAValue) {
    struct Case {
        std::function<void(host::Snapshot&)> with;
        Codes hops;
    };
    const std::vector<Case> cases{
        {[](auto&) {}, {"enabled", "period", "queue", "connected", "answers"}},
        {[](auto& s) { s.lines[0].variables[0].recent_period = {}; },
         {"enabled", "period_unmeasured", "queue", "connected", "answers"}},
        {[](auto& s) { s.lines[0].variables[0].overrun = true; },
         {"enabled", "overrun!", "queue", "connected", "answers"}},
        {[](auto& s) { s.lines[0].statistics.recent_utilization = 1; },
         {"enabled", "period", "busy!", "connected", "answers"}},
        {[](auto& s) { s.lines[0].up = false; }, {"enabled", "period", "queue", "lost!"}},
        {[](auto& s) { s.lines[0].up = s.lines[0].was_up = false; },
         {"enabled", "period", "queue", "never_connected!"}},
        {[](auto& s) { s.lines[0].devices[0].state = poll::DeviceState::not_answering; },
         {"enabled", "period", "queue", "connected", "silent!", "back_off?"}},
        {[](auto& s) { s.lines[0].devices[0].state = poll::DeviceState::unknown; },
         {"enabled", "period", "queue", "connected", "not_asked?"}},
        {[](auto& s) { s.values[s.configuration->find("Level")->value].reason = value::exception_reason(2); },
         {"enabled", "period", "queue", "connected", "refuses!"}},
        {[](auto& s) { s.values[s.configuration->find("Level")->value].reason = value::Reason::timeout; },
         {"enabled", "period", "queue", "connected", "fails!"}},
        {[](auto& s) {
             s.values[s.configuration->find("enabled")->value].value = false;
             s.lines[0].devices[0].state = poll::DeviceState::switched_off;
         },
         {"switched_off?", "period", "queue", "connected"}},
    };
    const auto before = state();
    for (std::size_t i = 0; i < cases.size(); ++i) {
        auto snapshot = before;
        cases[i].with(snapshot);
        EXPECT_EQ(codes(snapshot, "Level"), cases[i].hops) << i;
    }
    EXPECT_EQ(codes(before, "Command"), Codes{"not_read?"});
    EXPECT_EQ(codes(before, "go"), Codes{"local"});
    EXPECT_EQ(codes(before, "Asked").at(1), "also_trigger");
}

TEST(Why, SpeaksEachLanguageWithoutPlaceholders) {
    const auto before = state();
    for (const auto language : text::kLanguages) {
        for (int kind = 0; kind < 3; ++kind) {
            auto snapshot = before;
            if (kind == 1) snapshot.lines[0].up = false;
            if (kind == 2) snapshot.lines[0].devices[0].state = poll::DeviceState::not_answering;
            if (kind == 2) snapshot.lines[0].devices[0].failure = value::Reason::timeout;
            const auto text =
                why_json(report::Texts(language), snapshot, *snapshot.configuration->find("Level")).dump();
            EXPECT_EQ(text.find("{local}"), std::string::npos) << text;
            EXPECT_EQ(text.find("{error}"), std::string::npos) << text;
            EXPECT_EQ(text.find("{reason}"), std::string::npos) << text;
            const auto trouble = report::device_trouble(report::Texts(language), snapshot, 0, 0);
            EXPECT_EQ(trouble.text.empty(), kind != 2);
            if (kind == 2) EXPECT_NE(text.find(trouble.text), std::string::npos) << "one text of one cause";
            if (kind == 2) EXPECT_NE(text.find(trouble.tried), std::string::npos) << trouble.tried;
            EXPECT_EQ(text.find("web.why"), std::string::npos) << text;
        }
    }
}

}  // namespace why_test
}  // namespace takt::web
