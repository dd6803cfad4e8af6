#include "takt/report/states/watch_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace watch_report_test {

using namespace test;
using namespace std::chrono_literals;

const Instant kNow = Instant{} + 10s;

std::vector<model::Variable> variables() {
    model::Variable speed{.name = "holding 5", .type = DataType::int16, .register_number = 5};
    model::Variable pump{.name = "coils 17",
                         .type = DataType::boolean,
                         .area = wire::Area::coil,
                         .register_number = 1,
                         .bit = 1};
    return {speed, pump};
}

std::vector<WatchedValue> values() {
    std::vector<WatchedValue> made(2);
    made[0].update(std::int64_t{-7}, kNow - 250ms);
    made[1].update(true, kNow - 250ms);
    return made;
}

WatchStatistics statistics() {
    WatchStatistics made{.samples = 12, .errors = 1, .time = {}};
    made.time.record(10ms);
    made.time.record(20ms);
    return made;
}

plan::Request request() {
    plan::Request made;
    made.read = wire::Function::read_holding_registers;
    made.start = 5;
    made.quantity = 3;
    return made;
}

TEST(WatchedValue, CountsChangesAfterTheFirstRead) {
    WatchedValue watched;
    watched.trouble = "time-out";
    watched.update(std::int64_t{1}, kNow);
    EXPECT_TRUE(watched.changed);
    EXPECT_EQ(watched.changes, 0U);
    EXPECT_EQ(watched.trouble, "");
    watched.update(std::int64_t{1}, kNow + 1s);
    EXPECT_FALSE(watched.changed);
    EXPECT_EQ(watched.read_at, kNow + 1s);
    watched.update(std::int64_t{2}, kNow + 2s);
    EXPECT_TRUE(watched.changed);
    EXPECT_EQ(watched.changes, 1U);
}

TEST(WatchReport, ALineForEachValue) {
    const auto named = variables();
    auto watched = values();
    const WatchReport report(english(), named, false);
    EXPECT_EQ(report.lines("12:00:00.123", watched),
              "12:00:00.123 holding 5 = -7\n12:00:00.123 coils 17 = 1\n");
    watched[0].trouble = "time-out";
    watched[1].read_at.reset();
    EXPECT_EQ(report.lines("12:00:00.123", watched), "") << "nothing was read";
    EXPECT_EQ(WatchReport(english(), {}, false).lines("x", {}), "");
}

TEST(WatchReport, OnlyChanges) {
    const auto named = variables();
    auto watched = values();
    watched[1].update(true, kNow);
    const WatchReport report(english(), named, true);
    EXPECT_EQ(report.lines("t", watched), "t holding 5 = -7\n");
    EXPECT_EQ(size_of(at(report.sample_json("t", 0s, 1, watched, {}), "values")), 1U);
    watched[0].changed = false;
    EXPECT_EQ(report.lines("t", watched), "");
    EXPECT_EQ(report.sample_json("t", 0s, 1, watched, {}), file::Json());
    const auto failed = request();
    const std::vector<FailedRequest> failures{{&failed, fail(Code::timed_out, "x", 100).error()}};
    EXPECT_NE(report.sample_json("t", 0s, 1, watched, failures), file::Json());
}

TEST(WatchReport, FailuresInEveryLanguage) {
    const auto failed = request();
    const auto error = fail(Code::timed_out, "rtu:///dev/ttyS1", 100).error();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(WatchReport(texts, {}, false).failure_line("12:00", {&failed, error}),
                  "12:00 0x03 5..7: " + texts.describe(error));
    }
}

TEST(WatchReport, SamplesAsJson) {
    const auto named = variables();
    const auto watched = values();
    const auto failed = request();
    const std::vector<FailedRequest> failures{{&failed, fail(Code::timed_out, "x", 100).error()}};
    const auto json = WatchReport(english(), named, false)
                          .sample_json("2024-01-01T00:00:00.000Z", 1500ms, 3, watched, failures);
    EXPECT_JSON(at(json, "event"), "sample");
    EXPECT_JSON(at(json, "sample"), 3);
    EXPECT_JSON(at(json, "time_ms"), 1500);
    EXPECT_EQ(at(json, "values").dump(),
              R"([{"area":"holding","address":5,"type":"int16","value":-7,"changed":true},)"
              R"({"area":"coils","address":17,"type":"bool","value":true,"changed":true}])");
    EXPECT_JSON(at(json, "errors", 0, "code"), name(Code::timed_out));
    EXPECT_JSON(at(json, "errors", 0, "function"), 3);
    EXPECT_JSON(at(json, "errors", 0, "start"), 5);
    EXPECT_JSON(at(json, "errors", 0, "quantity"), 3);
}

TEST(WatchReport, ATableThatFitsTheScreen) {
    const auto named = variables();
    auto watched = values();
    watched[1].update(false, kNow);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        LiveSelection selection;
        const auto lines = WatchReport(texts, named, false, "tcp://plc, unit 1")
                               .table({24, 80}, kNow, watched, statistics(), {}, selection);
        ASSERT_EQ(lines.size(), 5U) << "the target, the statistics, a heading, two values";
        EXPECT_EQ(lines[0], "tcp://plc, unit 1: " + texts("app.state.answering"));
        expect_contains(lines[2], texts("app.value"));
        expect_contains(lines[3], "holding 5");
        expect_contains(lines[3], texts.duration(250ms));
        expect_contains(lines[4], "0  *");
        for (const auto& line : lines) {
            expect_complete(line);
            EXPECT_LT(display_width(line), language == text::Language::english ? 80U : 200U);
        }
    }
}

TEST(WatchReport, HiddenRowsAreCounted) {
    const std::vector<model::Variable> named(1000, variables()[0]);
    const std::vector<WatchedValue> watched(1000);
    const WatchReport report(english(), named, false);
    LiveSelection selection;
    const auto lines = report.table({24, 80}, kNow, watched, {}, {}, selection);
    ASSERT_EQ(lines.size(), 23U);
    expect_contains(lines[22], english()("app.more_rows", {{"count", "981"}}));
    expect_contains(lines[3], "–");
    EXPECT_EQ(report.table({1, 80}, kNow, watched, {}, {}, selection).size(), 7U)
        << "three rows even on a tiny screen";
    selection = {.first = 990, .takes_keys = true};
    expect_contains(report.table({24, 80}, kNow, watched, {}, {}, selection).back(), "982–1000");
}

TEST(WatchReport, WhatWasNotReadIsReadableAt80Columns) {
    const auto named = variables();
    auto watched = values();
    const auto failed = request();
    const auto error = fail(Code::modbus_exception, 2).error();
    watched[1].trouble = reason_text(english(), error);
    const std::vector<FailedRequest> failures{{&failed, error}};
    LiveSelection selection;
    const WatchReport report(english(), named, false, "tcp://192.168.100.100:5020, unit 1");
    const auto lines = report.table({24, 80}, kNow, watched, statistics(), failures, selection);
    EXPECT_EQ(lines[0], "tcp://192.168.100.100:5020, unit 1: exception 2");
    EXPECT_TRUE(lines[3].starts_with("coils 17")) << "at the top";
    EXPECT_TRUE(lines[3].ends_with("exception 2")) << lines[3];
    std::string below;
    for (std::size_t i = 5; i < lines.size(); ++i) {
        EXPECT_LT(display_width(lines[i]), 80U);
        below += lines[i] + ' ';
    }
    expect_contains(below, "0x03 5..7:");
    expect_contains(below, "illegal data address");
    const std::vector<FailedRequest> many(3, failures[0]);
    const auto crowded = report.table({24, 80}, kNow, watched, statistics(), many, selection);
    EXPECT_LE(crowded.size(), 9U) << "two lines, a heading, two values, four lines of failures";
    EXPECT_TRUE(crowded.back().ends_with('.')) << "no failure is cut: " << crowded.back();
    for (const auto code : {Code::timed_out, Code::bad_checksum, Code::connection_lost, Code::cannot_open,
                            Code::malformed, Code::queue_full})
        for (const auto language : kLanguages)
            EXPECT_LT(display_width(reason_text(Texts(language), fail(code).error())), 40U);
}

TEST(WatchReport, TheEventOfAConnectionThatWasNotMade) {
    const auto error = fail(Code::cannot_open, "tcp://h\"\n", 111).error();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto json = watch_error_json(texts, error);
        EXPECT_JSON(at(json, "event"), "error");
        EXPECT_JSON(at(json, "code"), "cannot_open");
        EXPECT_JSON(at(json, "text"), texts.describe(error));
    }
}

TEST(WatchReport, Statistics) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const WatchReport report(texts, {}, false);
        EXPECT_EQ(report.statistics_text(statistics()),
                  texts("app.watch.statistics", {{"samples", "12"},
                                                 {"answers", "2"},
                                                 {"errors", "1"},
                                                 {"min", texts.duration(10ms)},
                                                 {"mean", texts.duration(15ms)},
                                                 {"max", texts.duration(20ms)}}));
        expect_complete(report.statistics_text({}));
    }
    EXPECT_EQ(watch_summary_json(statistics()).dump(),
              R"({"event":"summary","samples":12,"answers":2,"errors":1,"min_ms":10.0,"mean_ms":15.0,)"
              R"("max_ms":20.0})");
    EXPECT_JSON(at(watch_summary_json({}), "min_ms"), file::Json());
}

}  // namespace watch_report_test
}  // namespace takt::report
