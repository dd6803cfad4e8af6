#include "takt/report/times/history_report.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

#include "sample.hpp"
#include "takt/report/drawing/svg.hpp"
#include "takt/report/times/history_svg.hpp"
#include "takt/report/times/history_time.hpp"

namespace takt::report {
namespace history_report_test {

using namespace test;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kNow = 1'790'000'000 * kSecond;  // 2026-09-21T14:13:20Z

class HistoryTime : public testing::Test {
protected:
    HistoryTime() { set("EET-2EEST,M3.5.0/3,M10.5.0/4"); }
    ~HistoryTime() override { set("UTC"); }
    static void set(const char* zone) {
        ::setenv("TZ", zone, 1);
        ::tzset();
    }
};

TEST_F(HistoryTime, IsParsed) {
    const struct {
        const char* text;
        const char* utc;
    } kCases[] = {
        {"now", "2026-09-21T14:13:20.000Z"},
        {"-2h", "2026-09-21T12:13:20.000Z"},
        {"-1.5d", "2026-09-20T02:13:20.000Z"},
        {"-1min", "2026-09-21T14:12:20.000Z"},
        {"-1m", "2026-09-21T14:12:20.000Z"},
        {"-250ms", "2026-09-21T14:13:19.750Z"},
        {"2026-11-24", "2026-11-23T22:00:00.000Z"},
        {"2026-07-01", "2026-06-30T21:00:00.000Z"},
        {"2026-11-24T10:00", "2026-11-24T08:00:00.000Z"},
        {"2026-11-24 10:00:30.25", "2026-11-24T08:00:30.250Z"},
        {"2026-11-24T10:00:00Z", "2026-11-24T10:00:00.000Z"},
        {"2026-11-24T10:00:00-05:30", "2026-11-24T15:30:00.000Z"},
        {"1969-12-31T23:59:59.5Z", "1969-12-31T23:59:59.500Z"},
    };
    for (const auto& [text, utc] : kCases) {
        const auto time = parse_history_time(text, kNow);
        ASSERT_TRUE(time) << text;
        EXPECT_EQ(utc_time_text(*time), utc) << text;
    }
}

TEST_F(HistoryTime, OfAnotherFormIsRejected) {
    for (const char* text : {"",
                             "-",
                             "-2",
                             "-2x",
                             "-h",
                             "--2h",
                             "-infh",
                             "-nand",
                             "-1e300d",
                             "today",
                             "2026-02-30",
                             "2026-13-01",
                             "2026-11-24T24:00",
                             "2026-11-24T10",
                             "2026-11-24T10:60",
                             "2026-11-24T10:00:00.",
                             "2026-11-24T10:00:00Zx",
                             "2026-11-24T10:00+2",
                             "2026-03-29T03:30" /* left out by summer time */,
                             "9999-01-01",
                             "26-11-24"})
        EXPECT_FALSE(parse_history_time(text, kNow)) << text;
}

TEST_F(HistoryTime, IsWritten) {
    EXPECT_EQ(local_time_text(kNow), "2026-09-21T17:13:20.000+03:00");
    EXPECT_EQ(short_time_text(kNow, kNow + kSecond), "17:13:20");
    EXPECT_EQ(short_time_text(kNow, 0), "2026-09-21 17:13:20");
}

HistoryView view() {
    HistoryView view{{"tank.level", "tank", DataType::int16, true, "m"}, {}, {}};
    auto& picture = view.picture;
    picture.range = {kNow, kNow + 100 * kSecond};
    picture.known_until_ns = kNow + 100 * kSecond;
    picture.min = 1;
    picture.max = 3;
    picture.mean = 1.75;
    picture.good_share = 0.8;
    picture.samples = 3;
    picture.held = store::HistoryPoint{kNow - kSecond, 1, {}};
    const auto add = [&picture](std::int64_t second, double value) {
        const store::HistoryPoint point{kNow + second * kSecond, value, kNow + (second - 5) * kSecond};
        picture.pixels.push_back({.index = static_cast<std::size_t>(second * 10),
                                  .range = {point.time_ns, point.time_ns + kSecond / 10},
                                  .samples = 1,
                                  .first = point,
                                  .min = point,
                                  .max = point,
                                  .last = point,
                                  .has_value = true});
    };
    add(20, 3);
    add(60, 2);
    picture.gaps = {{kNow + 40 * kSecond, kNow + 50 * kSecond, store::GapCause::quota, 17}};
    picture.bad = {
        {{kNow + 80 * kSecond, kNow + 90 * kSecond}, value::Quality::bad, value::Reason::not_answering}};
    view.last = store::HistorySample{.time_ns = kNow + 60 * kSecond, .value = 2.0};
    return view;
}

TEST(HistoryReport, SaysWhatHappenedInEveryLanguage) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = history_text(texts, {view()}, 80);
        expect_contains(text, "tank.level");
        expect_contains(text, "1.75");
        expect_contains(text, "80.00 %");
        expect_contains(text, gap_text(texts, store::GapCause::quota));
        expect_contains(text, texts("app.history.lost", {{"count", "17"}}));
        expect_contains(text, texts.quality(value::Quality::bad, value::Reason::not_answering));
        expect_contains(text, "▁");
        expect_contains(text, "█");
        expect_complete(text);
    }
}

TEST(HistoryReport, JsonHasPointsGapsAndBadTimes) {
    const std::vector<store::HistoryDamage> damage{{.part = store::HistoryPart::log, .row = 7}};
    const auto text = history_json({view()}, {kNow, kNow + kSecond}, damage).dump();
    expect_contains(text, R"("from":"2026-09-21T14:13:20.000Z")");
    expect_contains(text, R"("held":{"time":"2026-09-21T14:13:19.000Z","value":1)");
    expect_contains(text, R"("previous_poll":"2026-09-21T14:13:35.000Z")");
    expect_contains(text, R"("cause":"quota","samples":17)");
    expect_contains(text, R"("reason":"not_answering","status":105)");
    expect_contains(text, R"("damage":[{"part":"log","row":7,"variable":null,"from":null)");
}

TEST(HistoryReport, NamesDamageWithVariableAndTime) {
    const store::HistoryDamage damaged{.part = store::HistoryPart::chunk,
                                       .row = 3,
                                       .variable = "tank.level",
                                       .first_ns = kNow,
                                       .last_ns = kNow + kSecond,
                                       .samples = 17};
    for (const auto language : kLanguages) {
        using enum store::HistoryPart;
        const Texts texts(language);
        std::vector<store::HistoryDamage> all{damaged};
        for (const auto part : {log, rollup, gap, series, state, recorded}) all.push_back({.part = part});
        const auto text = history_damage_text(texts, all);
        expect_contains(text, "tank.level");
        expect_contains(text, texts("app.history.lost", {{"count", "17"}}));
        expect_complete(text);
    }
    EXPECT_EQ(history_damage_text(english(), {}), "");
    const auto row = history_csv_row(damaged);
    EXPECT_TRUE(row.starts_with("tank.level,2026-09-21T14:13:20.000Z,")) << row;
    EXPECT_TRUE(row.ends_with(",,damaged,chunk until 2026-09-21T14:13:21.000Z,\n")) << row;
}

TEST(HistoryReport, CsvQuotesCells) {
    const store::HistorySample sample{.time_ns = kNow,
                                      .value = std::string("a,\"b\""),
                                      .quality = value::Quality::bad,
                                      .reason = value::Reason::timeout};
    const auto row = history_csv_row({"x,y", "", DataType::string, false, ""}, sample);
    EXPECT_TRUE(row.starts_with("\"x,y\",2026-09-21T14:13:20.000Z,")) << row;
    EXPECT_TRUE(row.ends_with(",\"a,\"\"b\"\"\",bad,timeout,\n")) << row;
}

TEST(HistorySvg, DrawsStepsHolesAndAgeBands) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto svg = history_svg(texts, "A <title>", {view(), view()});
        EXPECT_TRUE(well_formed(svg));
        for (const char* style : {"lost", "dead", "bad", "band"})
            expect_contains(svg, xml_text(texts(std::string("app.history.legend.") + style)));
        expect_contains(svg, "<rect class=\"lost\" x=\"490\"");
        expect_contains(svg, "<rect class=\"dead\" x=\"890\"");
        expect_contains(svg, "<rect class=\"band\" x=\"240\"");  // from the poll 5 s before the change
        expect_contains(svg, "prefers-color-scheme:dark");
        // Held until the gap, then again from the next sample until the device is dead.
        expect_contains(svg, "H490.00M690.00");
        expect_contains(svg, "H890.00\"");
    }
}

TEST(HistorySvg, DrawsAVariableWithoutNumbers) {
    HistoryView empty = view();
    empty.picture = {};
    empty.picture.range = {kNow, kNow + kSecond};
    EXPECT_TRUE(well_formed(history_svg(english(), "", {empty})));
    expect_contains(history_text(english(), {empty}, 40), "–");
}

}  // namespace history_report_test
}  // namespace takt::report
