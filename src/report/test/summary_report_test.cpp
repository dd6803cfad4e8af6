#include "takt/report/states/summary_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "host_sample.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace summary_report_test {

using namespace test;
using namespace std::chrono_literals;

bus::TransactionCounters counters() {
    bus::TransactionCounters made;
    made.sent = 20;
    made.answered = 9;
    made.timeouts = 4;
    made.checksums = 3;
    made.unexpected = 2;
    made.ambiguous = 5;
    made.link_lost = 1;
    made.exceptions = 3;
    made.exceptions_by_code[2] = 2;
    made.exceptions_by_code[0] = 1;
    made.time.record(10ms);
    made.time.record(30ms);
    return made;
}

const std::string kCounters =
    R"("sent":20,"answered":9,"timeouts":4,"checksums":3,"unexpected":2,"ambiguous":5,"link_lost":1,)"
    R"("exceptions":3,)"
    R"("exceptions_by_code":{"other":1,"2":2},"mean_ms":20.0,"longest_ms":30.0)";
const std::string kNoCounters =
    R"("sent":0,"answered":0,"timeouts":0,"checksums":0,"unexpected":0,"ambiguous":0,"link_lost":0,)"
    R"("exceptions":0,)"
    R"("exceptions_by_code":{},"mean_ms":null,"longest_ms":null)";

host::Snapshot measured() {
    auto made = snapshot_of(plant());
    auto& line = made.lines[0];
    line.statistics.planned_cycle = 62500us;
    line.statistics.measured_cycle = 80ms;
    line.statistics.utilization = 0.123;
    line.devices[0].state = poll::DeviceState::not_answering;
    line.devices[0].counters = counters();
    line.devices[0].outages = 5;
    line.devices[0].availability.begin(made.started);
    line.devices[0].availability.up(made.started);
    line.devices[0].availability.down(made.t - 3s);
    line.devices[0].late = 8;
    line.devices[0].delays = {poll::DelayFinding::Setting::response_timeout, 148ms, 100ms, 300ms, 9};
    line.devices[0].noise = poll::NoiseFinding{.least = 1, .most = 1};
    line.statistics.availability.begin(made.started);
    line.statistics.availability.up(made.started);
    line.requests[0].counters = counters();
    return made;
}

/// The lines of a summary, without the blanks between their columns.
std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines{""};
    for (const char c : text) {
        if (c == '\n')
            lines.emplace_back();
        else if (c != ' ' || !lines.back().ends_with(' '))
            lines.back() += c;
    }
    return lines;
}

TEST(SummaryReport, TextInEveryLanguage) {
    const auto snapshot = measured();
    const auto requests = snapshot.lines[0].requests.size();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = summary_text(texts, snapshot);
        expect_complete(text);
        const auto lines = lines_of(text);
        ASSERT_EQ(lines.size(), 2 + 2 + 2 + 1 + 1 + requests + 1) << text;
        EXPECT_EQ(lines[0], texts("app.summary.line", {{"line", "main"},
                                                       {"duration", texts.duration(10s)},
                                                       {"planned", texts.duration(62500us)},
                                                       {"measured", texts.duration(80ms)},
                                                       {"utilization", "12.3 %"}}));
        const auto of_code = [&](const char* count, const char* code) {
            return texts("app.exceptions.of_code", {{"count", count}, {"code", code}});
        };
        const auto exceptions = of_code("1", "?") + ", " + of_code("2", "2");
        EXPECT_EQ(lines[1], ' ' + texts("app.summary.availability",
                                        {{"available", "100.00 %"}, {"down", texts.duration(0s)}}));
        EXPECT_EQ(lines[3], " Котёл " + texts("app.state.not_answering") + " 20 9 15 " + exceptions + " 5 " +
                                texts.duration(3s) + " 70.00 %");
        EXPECT_EQ(lines[4],
                  ' ' + texts("app.delays.response_timeout",
                              {{"where", "Котёл"}, {"delay", "148"}, {"limit", "100"}, {"advised", "300"}}));
        const auto key = request_text(snapshot.lines[0].plan->requests[0]);
        EXPECT_EQ(lines[5], ' ' + texts("app.noise", {{"where", "Котёл"}, {"count", "1"}}));
        EXPECT_EQ(lines[8], " Котёл " + key + " 20 9 4 11 " + exceptions + " " + texts.duration(20ms) + " " +
                                texts.duration(30ms) + " " + texts("app.on_demand"));
    }
}

/// The longest line.
std::size_t width_of(const std::string& text) {
    std::istringstream lines(text);
    std::size_t most = 0;
    for (std::string line; std::getline(lines, line);) most = std::max(most, display_width(line));
    return most;
}

TEST(SummaryReport, ANarrowTerminalHasFailuresBelowTheRows) {
    auto snapshot = measured();
    snapshot.lines[0].requests[0].period = 1000ms;
    snapshot.lines[0].requests[0].real_period.record(1000ms);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        ASSERT_GT(width_of(summary_text(texts, snapshot)), 80U);
        const auto text = summary_text(texts, snapshot, 80);
        EXPECT_LE(width_of(text), 80U) << text;
        expect_complete(text);
        const auto exceptions = texts("app.exceptions.of_code", {{"count", "1"}, {"code", "?"}}) + ", " +
                                texts("app.exceptions.of_code", {{"count", "2"}, {"code", "2"}});
        expect_contains(text, "\n      └ " + texts("app.failed") + ": 15, " + exceptions + '\n');
        expect_contains(text, "\n      └ " + texts("app.timeouts") + ": 4, " + texts("app.faults") +
                                  ": 11, " + exceptions + '\n');
    }
    EXPECT_EQ(summary_text(english(), snapshot, 200), summary_text(english(), snapshot));
    EXPECT_FALSE(summary_text(english(), snapshot, 1).empty());
}

TEST(SummaryReport, PeriodsOfRequests) {
    bus::TimeStatistics real;
    real.record(510ms);
    const struct {
        std::optional<Duration> period;
        bus::TimeStatistics real;
        bool overrun;
        std::string text, json;
    } cases[] = {
        {std::nullopt,
         {},
         false,
         english()("app.on_demand"),
         R"("period_ms":null,"real_period_ms":null,"overrun":false)"},
        {500ms, {}, false, "500 ms → –", R"("period_ms":500.0,"real_period_ms":null,"overrun":false)"},
        {500ms, real, false, "500 ms → 510 ms",
         R"("period_ms":500.0,"real_period_ms":510.0,"overrun":false)"},
        {500ms, real, true, "500 ms → 700 ms !",
         R"("period_ms":500.0,"real_period_ms":510.0,"overrun":true)"},
        {0ms, real, false, "0 ms → 510 ms", R"("period_ms":0.0,"real_period_ms":510.0,"overrun":false)"},
    };
    for (const auto& [period, measured_period, overrun, text, json] : cases) {
        auto snapshot = snapshot_of(plant());
        auto& request = snapshot.lines[0].requests[0];
        request.period = period;
        request.real_period = measured_period;
        request.recent_period = 700ms;
        request.overrun = overrun;
        EXPECT_TRUE(lines_of(summary_text(english(), snapshot))[6].ends_with(' ' + text)) << text;
        expect_contains(at(summary_json(snapshot), "lines", 0, "requests", 0).dump(), json);
    }
}

TEST(SummaryReport, StatesOfDevicesAsText) {
    for (const auto state :
         {poll::DeviceState::unknown, poll::DeviceState::answering, poll::DeviceState::not_answering,
          poll::DeviceState::switched_off, poll::DeviceState::link_down}) {
        auto snapshot = snapshot_of(plant());
        snapshot.lines[0].devices[0].state = state;
        expect_contains(summary_text(english(), snapshot),
                        english()("app.state." + std::string(poll::name(state))));
        EXPECT_JSON(at(summary_json(snapshot), "lines", 0, "devices", 0, "state"), poll::name(state));
    }
}

TEST(SummaryReport, JsonOfALine) {
    auto snapshot = measured();
    auto& statistics = snapshot.lines[0].statistics.counters;
    static_cast<bus::TransactionCounters&>(statistics) = counters();
    statistics.foreign_frames = 11;
    statistics.late_answers = 12;
    statistics.faults = 13;
    statistics.unsolicited_bytes = 14;
    statistics.echoes = 15;
    snapshot.lines[0].times[0] = {
        .exchanges = 3120, .longest = 7600us, .p999 = 7100us, .attempts = 3128, .late = 8, .lateness = 148ms};
    statistics.noisy_answers = 16;
    statistics.noise_bytes = 17;
    snapshot.lines[0].devices[0].counters.noisy_answers = 2;
    snapshot.lines[0].devices[0].counters.noise_bytes = 3;
    snapshot.lines[0].devices[0].verified = 6;
    snapshot.lines[0].devices[0].differed = 7;
    const auto json = summary_json(snapshot);
    EXPECT_TRUE(
        json.dump().starts_with(R"({"event":"summary","duration_ms":10000.0,"lines":[{"name":"main",)"
                                R"("planned_cycle_ms":62.5,"measured_cycle_ms":80.0,"utilization":0.123,)"
                                R"("availability_percent":100.0,"downtime_ms":0.0,)"))
        << json.dump();
    EXPECT_EQ(at(json, "lines", 0, "counters").dump(),
              '{' + kCounters +
                  R"(,"foreign_frames":11,"late_answers":12,"faults":13,"unsolicited_bytes":14,"echoes":15,)"
                  R"("noisy_answers":16,"noise_bytes":17})");
    EXPECT_EQ(
        at(json, "lines", 0, "devices").dump(),
        R"([{"name":"Котёл","state":"not_answering","outages":5,"availability_percent":70.0,)"
        R"("downtime_ms":3000.0,"late_answers":8,"surplus_answers":0,)"
        R"("delays":{"setting":"response_timeout","delay_ms":148.0,)"
        R"("limit_ms":100.0,"advised_ms":300.0,"count":9,"later":0},"noisy_answers":2,"noise_bytes":3,)"
        R"("noise":{"least_bytes":1,"most_bytes":1},)"
        R"("turnaround":{"exchanges":3120,"longest_ms":7.6,"p999_ms":7.1,)"
        R"("learnt":false,"advised":null},"late_responses":{"count":8,"requests":3128,"longest_ms":148.0},)"
        R"("verified":6,"differed":7,"counters":{)" +
            kCounters + "}}]");
    EXPECT_EQ(size_of(at(json, "lines", 0, "requests")), snapshot.lines[0].plan->requests.size());
}

TEST(SummaryReport, JsonOfARequest) {
    auto snapshot = snapshot_of(plant());
    auto plan = *snapshot.lines[0].plan;
    plan.requests.resize(2);
    plan.requests[0].read = wire::Function::read_holding_registers;
    plan.requests[0].write = {};
    plan.requests[0].start = 500;
    plan.requests[0].quantity = 4;
    plan.requests[1].read = {};
    plan.requests[1].write = wire::Function::write_single_coil;
    plan.requests[1].start = 3;
    plan.requests[1].quantity = 1;
    snapshot.lines[0].plan = std::make_shared<const plan::LinePlan>(plan);
    snapshot.lines[0].requests.resize(2);
    snapshot.lines[0].requests[0].skipped = 8;
    snapshot.lines[0].requests[0].over_cost = 9;
    snapshot.lines[0].requests[0].late_refreshes = 10;
    const auto json = summary_json(snapshot);
    const std::string times = R"("period_ms":null,"real_period_ms":null,"overrun":false,"skipped":)";
    EXPECT_EQ(at(json, "lines", 0, "requests").dump(),
              R"([{"device":"Котёл","function":3,"write_function":null,"start":500,"quantity":4,)" + times +
                  R"(8,"longer_than_proved":9,"late_refreshes":10,"counters":{)" + kNoCounters +
                  R"(}},{"device":"Котёл","function":null,"write_function":5,"start":3,"quantity":1,)" +
                  times + R"(0,"longer_than_proved":0,"late_refreshes":0,"counters":{)" + kNoCounters +
                  "}}]");
    expect_contains(summary_text(english(), snapshot), "0x03 500..503");
}

TEST(SummaryReport, NothingMeasuredIsADashAndNull) {
    const auto snapshot = snapshot_of(plant());
    const auto lines = lines_of(summary_text(english(), snapshot));
    expect_contains(lines[0], "measured –");
    expect_contains(lines[1], "available –");
    EXPECT_TRUE(lines[3].ends_with(" 0 ms –")) << lines[3];
    expect_contains(lines[6], " – – ");
    const auto line = at(summary_json(snapshot), "lines", 0);
    expect_contains(line.dump(), R"("measured_cycle_ms":null)");
    expect_contains(line.dump(), R"("availability_percent":null,"downtime_ms":0.0)");
    expect_contains(at(line, "devices", 0).dump(),
                    R"("delays":null,"noisy_answers":0,"noise_bytes":0,"noise":null)");
    expect_contains(at(line, "devices", 0).dump(), R"("turnaround":null,"late_responses":null)");
}

TEST(SummaryReport, NoiseBetweenTheTransactionsIsNamed) {
    const auto shown = [](std::uint64_t bytes, std::uint64_t answered, std::uint64_t late,
                          std::uint64_t foreign) {
        auto snapshot = snapshot_of(plant());
        auto& counters = snapshot.lines[0].statistics.counters;
        counters.unsolicited_bytes = bytes;
        counters.answered = answered;
        counters.late_answers = late;
        counters.foreign_frames = foreign;
        const auto text = summary_text(english(), snapshot);
        return text.find("\n  " + std::to_string(bytes) +
                         " bytes of noise while no request was in flight on main: "
                         "check bias and driver enable\n") != std::string::npos;
    };
    EXPECT_TRUE(shown(360, 360, 0, 0));
    EXPECT_TRUE(shown(3, 300, 0, 0));
    EXPECT_FALSE(shown(3, 301, 0, 0)) << "single glitches are only counted";
    EXPECT_FALSE(shown(2, 2, 0, 0));
    EXPECT_FALSE(shown(360, 360, 1, 0)) << "bytes of a late response";
    EXPECT_FALSE(shown(360, 360, 0, 1)) << "bytes of another master";
}

TEST(SummaryReport, ResponseTimesOfADevice) {
    auto project = project_of(kPlant);
    project.lines[0].devices[0].turnaround.reset();
    auto snapshot = snapshot_of(configuration_of(project));
    auto& times = snapshot.lines[0].times[0];
    times = {.exchanges = 12, .longest = 7600us, .p999 = 7600us, .attempts = 12};
    expect_contains(summary_text(english(), snapshot),
                    "\n  Котёл: turnaround of responses in time at most 7.60 ms, exchanges measured: 12, "
                    "too few to use\n");
    times = {
        .exchanges = 3120, .longest = 7600us, .p999 = 7100us, .attempts = 3123, .late = 3, .lateness = 412ms};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = summary_text(texts, snapshot);
        expect_complete(text);
        expect_contains(text,
                        texts("app.turnaround.late",
                              {{"device", "Котёл"},
                               {"longest", texts.duration(7600us)},
                               {"p999", texts("app.turnaround.p999", {{"p999", texts.duration(7100us)}})},
                               {"count", "3120"}}));
        expect_contains(text, texts("app.late_responses", {{"device", "Котёл"},
                                                           {"late", "3"},
                                                           {"attempts", "3123"},
                                                           {"lateness", texts.duration(412ms)}}));
    }
    expect_contains(summary_text(english(), snapshot),
                    "Котёл: turnaround of responses in time at most 7.60 ms, 99.9 % within 7.10 ms");
    EXPECT_JSON(at(summary_json(snapshot), "lines", 0, "devices", 0, "turnaround", "advised"), file::Json());
    times.late = 0;
    times.lateness = {};
    expect_contains(summary_text(english(), snapshot), "over 3120 exchanges: turnaround: 10ms\n");
    times.exchanges = 999;
    expect_contains(summary_text(english(), snapshot),
                    "Котёл: turnaround at most 7.60 ms, measured over 999 exchanges: turnaround: 10ms\n");
    EXPECT_JSON(at(summary_json(snapshot), "lines", 0, "devices", 0, "turnaround", "p999_ms"), file::Json());
}

TEST(SummaryReport, SeveralLinesAndNone) {
    auto snapshot = snapshot_of(configuration_of(project_of(kPlant.substr(0, kPlant.find("locals:")) +
                                                            kEmptyLine.substr(kEmptyLine.find("  - name")))));
    ASSERT_EQ(snapshot.lines.size(), 2U);
    const auto json = summary_json(snapshot);
    EXPECT_JSON(at(json, "lines", 1, "name"), "net");
    EXPECT_EQ(at(json, "lines", 1, "requests").dump(), "[]");
    expect_contains(summary_text(english(), snapshot), "Meter");
    expect_contains(summary_text(english(), snapshot), "\n\nnet: 10 s");

    const auto none = snapshot_of(configuration_of({}));
    EXPECT_EQ(summary_text(english(), none), "");
    EXPECT_EQ(summary_json(none).dump(), R"({"event":"summary","duration_ms":10000.0,"lines":[]})");
}

}  // namespace summary_report_test
}  // namespace takt::report
