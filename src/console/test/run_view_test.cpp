// Views fed with events by hand.
#include "takt/console/run_view.hpp"

#include <gtest/gtest.h>

#include "support.hpp"
#include "takt/console/clock_text.hpp"

namespace takt::console {
namespace run_view_test {

using namespace test;

class RunViewTest : public testing::Test {
protected:
    RunViewTest()
        : configuration(host::test::configuration_of(kPlant)),
          out(std::make_unique<os::LineWriter>(memory.sink(), output_options(true))) {
        last.configuration = configuration;
        last.started = Instant{1s};
        last.t = Instant{5s};
        last.values.resize(configuration->slot_count());
        last.lines.resize(1);
        last.lines[0].devices.resize(1);
        last.lines[0].times.resize(1);
        last.lines[0].variables.resize(2);
        last.lines[0].plan = std::make_shared<const plan::LinePlan>(configuration->plan().lines[0]);
        last.lines[0].requests.resize(last.lines[0].plan->requests.size());
    }

    host::Event changed(double value, value::Quality quality = value::Quality::good) {
        host::ValueChanged body{.slot = *configuration->find("Pump speed"), .value = value::Value(value)};
        body.quality = quality;
        if (quality != value::Quality::good) body.reason = value::Reason::timeout;
        return {.generation = 1, .t = Instant{3s}, .body = body};
    }

    std::string written() {
        out->finish();
        return memory.text();
    }

    host::ConfigurationPtr configuration;
    Memory memory;
    std::unique_ptr<os::LineWriter> out;
    host::Snapshot last;
};

TEST_F(RunViewTest, JsonHasOneObjectALine) {
    const auto view = make_json_view(Instant{1s}, english(), *out);
    view->on_event(*configuration, changed(2.5));
    view->on_event(*configuration, {.t = Instant{3s}, .body = host::AuditRecorded{}});  // not for this view
    view->on_missed(7);
    auto answer = file::Json::object();
    answer.set("event", "answer");
    view->on_answer(Instant{4s}, {"ok\n", answer});
    std::vector<std::string> lines;
    std::istringstream stream(written());
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    ASSERT_EQ(lines.size(), 3U);
    EXPECT_NE(lines[0].find(R"("value":2.5)"), std::string::npos) << lines[0];
    EXPECT_NE(lines[0].find(R"("time_ms":2000)"), std::string::npos) << lines[0];
    EXPECT_NE(lines[0].find("\"time\":\"" + iso_time(Instant{3s}) + '"'), std::string::npos) << lines[0];
    EXPECT_NE(lines[1].find("7"), std::string::npos);
    EXPECT_NE(lines[2].find(R"("time_ms":3000)"), std::string::npos) << lines[2];
}

TEST_F(RunViewTest, JsonEndsWithTheSummary) {
    make_json_view(Instant{1s}, english(), *out)->end(last, {});
    EXPECT_NE(written().find(R"("event":"summary")"), std::string::npos) << memory.text();
    EXPECT_NE(memory.text().find("\"time\":\"" + iso_time(last.t) + '"'), std::string::npos) << memory.text();
}

TEST_F(RunViewTest, AnOutputIsALine) {
    publish::OutputStatus status;
    status.name = "cloud";
    make_line_view(english(), *out)->on_output(Instant{3s}, status);
    EXPECT_NE(written().find("output cloud: opening its journal"), std::string::npos) << memory.text();
}

TEST_F(RunViewTest, AnOutputIsInTheSummary) {
    publish::OutputStatus status;
    status.name = "cloud";
    make_json_view(Instant{1s}, english(), *out)->end(last, {status});
    EXPECT_NE(written().find(R"("outputs":[{"name":"cloud","state":"starting")"), std::string::npos)
        << memory.text();
}

TEST_F(RunViewTest, LinesBeginWithTheTime) {
    const auto view = make_line_view(english(), *out);
    view->on_event(*configuration, changed(2.5));
    view->on_event(*configuration, changed(2.5, value::Quality::bad));
    view->on_answer(Instant{4s}, {"ok Level 1\n", {}});
    const auto time = iso_time(Instant{3s});
    EXPECT_EQ(written(), time + " Boiler Pump speed = 2.5\n" + time + " Boiler Pump speed = 2.5 (" +
                             english().quality(value::Quality::bad, value::Reason::timeout) +
                             ")\nok Level 1\n");
}

TEST_F(RunViewTest, LinesOfATerminalAreBrokenAtBlanks) {
    const auto view = make_line_view(english(), *out, [] { return report::Screen{24, 44}; });
    view->on_event(*configuration, changed(2.5));
    EXPECT_EQ(written(), iso_time(Instant{3s}) + " Boiler Pump\n    speed = 2.5\n");
}

class LiveViewTest : public RunViewTest {
protected:
    host::test::Rig rig{kPlant};
    std::unique_ptr<host::Session> session = rig.open();
    report::Screen screen{24, 80};
    std::unique_ptr<RunView> view = make_live_view(*session, english(), *out, [this] { return screen; });
};

TEST_F(LiveViewTest, ShowsEveryValueInItsTableAndNotAsALine) {
    auto& slot = last.values[configuration->find("Level")->value];
    slot.value = value::Value(std::int64_t{17});
    slot.quality = value::Quality::good;
    slot.sampled_at = Instant{4s};
    view->on_event(*configuration, changed(2.5));
    view->end(last, {});
    const auto text = written();
    EXPECT_EQ(text.find(iso_time(Instant{3s})), std::string::npos);
    EXPECT_NE(text.find("Level"), std::string::npos);
    EXPECT_NE(text.find("17"), std::string::npos);
    EXPECT_NE(text.find("1 s"), std::string::npos) << "the age";
}

TEST_F(LiveViewTest, CountsTheRowsThatDoNotFit) {
    std::string yaml = kPlant;
    for (int i = 0; i < 20; ++i) yaml += "  - {name: local" + std::to_string(i) + ", type: bool}\n";
    last.configuration = host::test::configuration_of(yaml);
    last.values.resize(last.configuration->slot_count());
    screen.rows = 10;
    view->end(last, {});
    const auto more = english()("app.more_rows", {{"count", "18"}});  // 23 values, 5 rows
    EXPECT_NE(written().find(more), std::string::npos) << memory.text();
}

TEST_F(LiveViewTest, KeysChooseWhatIsShown) {
    const Key device{.name = Key::Name::character, .character = "d"};
    EXPECT_TRUE(view->on_key(device));
    EXPECT_FALSE(view->on_key({.name = Key::Name::character, .character = "q"}));
    view->end(last, {});
    const auto text = written();
    EXPECT_NE(text.find("Pump speed"), std::string::npos) << text;
    EXPECT_EQ(text.find("go "), std::string::npos) << "a local has no device: " << text;
}

TEST_F(LiveViewTest, OtherEventsScrollAwayAboveTheTable) {
    view->on_event(*configuration, {.t = Instant{3s}, .body = host::LinkChanged{.line = 0, .up = true}});
    view->on_answer(Instant{4s}, {"ok Level 1\n", {}});
    const auto text = written();
    EXPECT_NE(text.find(english()("app.link_up", {{"line", "main"}})), std::string::npos) << text;
    EXPECT_NE(text.find("ok Level 1\n"), std::string::npos);
}

TEST(OutputOptions, ReportMissedLinesInTheFormOfTheOutput) {
    EXPECT_EQ(output_options(false).gap_line(3), "… 3\n");
    EXPECT_NE(output_options(true).gap_line(3).find('{'), std::string::npos);
}

}  // namespace run_view_test
}  // namespace takt::console
