#include "takt/report/states/selftest_report.hpp"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "takt/text/catalogue.hpp"

namespace takt::report {
namespace selftest_report_test {

using namespace std::chrono_literals;

SelftestRun run_of(Duration longest) {
    SelftestRun run;
    for (auto& measured : run) {
        auto& statistics = measured.emplace();
        statistics.record(15us, 999);
        statistics.record(longest);
    }
    return run;
}

SelftestReport complete() {
    return {.idle = run_of(40us), .loaded = run_of(1234us), .load_threads = 2};
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(SelftestReport, ShowsBothRunsAHistogramAndTheHostLine) {
    const auto text = selftest_text(Texts(text::Language::english), complete());
    EXPECT_TRUE(has(text, "under load, threads: 2")) << text;
    EXPECT_TRUE(has(text, "1.23 ms")) << text;
    EXPECT_TRUE(has(text, "< 20.0 µs  999  #########################\n")) << text;
    EXPECT_TRUE(has(text, "< 50.0 µs    0\n")) << text;
    EXPECT_TRUE(has(text, "< 2.00 ms    1  #\n")) << text;
    EXPECT_TRUE(has(text, "host: {jitter: 1300us, overhead: 1300us}  # under load\n")) << text;
    EXPECT_TRUE(has(text, "host: {jitter: 100us, overhead: 100us}")) << text;
}

TEST(SelftestReport, WithoutAllMeasurementsThereIsNoHostLine) {
    auto report = complete();
    report.loaded[2].reset();
    const auto text = selftest_text(Texts(text::Language::english), report);
    EXPECT_FALSE(has(text, "host: {")) << text;
    EXPECT_TRUE(has(text, "No `host:` line: a measurement is missing")) << text;
    const auto json = selftest_json(report);
    EXPECT_NE(json.find("idle")->find("host"), nullptr);
    EXPECT_EQ(json.find("loaded")->find("host"), nullptr);
    EXPECT_TRUE(json.find("loaded")->find("pty")->is_null());
}

TEST(SelftestReport, AMeasurementWithoutSamplesHasNoTimes) {
    auto report = complete();
    report.loaded[1].emplace();
    const auto text = selftest_text(Texts(text::Language::english), report);
    EXPECT_TRUE(has(text, "No `host:` line")) << text;
    EXPECT_FALSE(has(text, "0 µs   0 µs")) << text;
    EXPECT_TRUE(has(text, "–")) << text;
}

TEST(SelftestReport, JsonHasTheSameFigures) {
    const auto text = selftest_json(complete()).dump();
    EXPECT_TRUE(has(text, R"("load_threads":2)")) << text;
    EXPECT_TRUE(has(text, R"("wake_up":{"samples":1000,"min_us":15.0)")) << text;
    EXPECT_TRUE(has(text, R"("max_us":1234.0)")) << text;
    EXPECT_TRUE(has(text, R"([20.0,999])")) << text;
    EXPECT_TRUE(has(text, R"("host":{"jitter":"1300us","overhead":"1300us"})")) << text;
}

}  // namespace selftest_report_test
}  // namespace takt::report
