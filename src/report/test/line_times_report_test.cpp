#include "takt/report/states/line_times_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "host_sample.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace line_times_report_test {

using namespace test;
using namespace std::chrono_literals;

poll::HistogramSnapshot measured() {
    poll::HistogramSnapshot times{.count = 100, .p50 = 5ms, .p99 = 7ms, .longest = 9ms, .buckets = {}};
    times.buckets.push_back({5000, 60});
    times.buckets.push_back({9000, 40});
    return times;
}

TEST(LineTimesReport, ShowsThePartsThatWereMeasured) {
    const Texts texts = english();
    EXPECT_EQ(line_times_text(texts, {}), "");
    EXPECT_EQ(line_times_text(texts, {.wire = {}, .turnaround = measured(), .host = {}}),
              "  turnaround of the devices: half within 5.00 ms, 99 % within 7.00 ms, longest 9.00 ms\n");
    auto short_ones = measured();
    short_ones.p50 = 0us;
    short_ones.longest = 520us;
    EXPECT_EQ(
        line_times_text(texts, {.wire = {}, .turnaround = {}, .host = short_ones}),
        "  wake-ups of this program, late by: half within 1.00 µs, 99 % within 0.520 ms, longest 0.520 ms\n");
}

TEST(LineTimesReport, JsonHasNullForWhatWasNotMeasured) {
    EXPECT_EQ(line_times_json({.wire = {}, .turnaround = measured(), .host = {}}).dump(),
              R"({"wire":null,"turnaround":{"count":100,"p50_us":5000,"p99_us":7000,"longest_us":9000,)"
              R"("histogram":[[5000,60],[9000,40]]},"host":null})");
}

TEST(LineTimesReport, NamesRequestsThatBrokeTheAssumptionsOfTheProof) {
    auto snapshot = snapshot_of(plant());
    EXPECT_EQ(broken_bounds_text(english(), snapshot, 0), "");
    auto& first = snapshot.lines[0].requests.at(0);
    first.over_cost = 3;
    first.late_refreshes = 1;
    first.counters.time.record(10ms);
    const auto text = broken_bounds_text(english(), snapshot, 0);
    EXPECT_EQ(text,
              "  Котёл " + request_text(snapshot.lines[0].plan->requests[0]) +
                  ": 3 of 1 transaction took longer than the proof assumes; values older than their bound: "
                  "1 times\n");
}

TEST(LineTimesReport, ManyRequestsAreCounted) {
    auto snapshot = snapshot_of(plant());
    auto plan = *snapshot.lines[0].plan;
    plan.requests.resize(20, plan.requests.front());
    snapshot.lines[0].plan = std::make_shared<const plan::LinePlan>(std::move(plan));
    snapshot.lines[0].requests.resize(20);
    for (auto& request : snapshot.lines[0].requests) request.late_refreshes = 1;
    const auto text = broken_bounds_text(english(), snapshot, 0);
    EXPECT_EQ(std::ranges::count(text, '\n'), 9);
    EXPECT_TRUE(text.ends_with("  and 12 requests more\n")) << text;
}

}  // namespace line_times_report_test
}  // namespace takt::report
