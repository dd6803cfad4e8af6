#include "takt/report/states/outputs_report.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "sample.hpp"
#include "states/problems.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::report {
namespace outputs_report_test {

using namespace test;

constexpr std::int64_t kSecond = 1'000'000'000;

publish::OutputStatus status() {
    publish::OutputStatus made;
    made.name = "cloud";
    made.state = publish::OutputState::waiting;
    made.destination = "mqtts://broker.example:8883";
    made.samples = {.sampled = 130, .delivered = 100, .waiting = 25, .dropped = 5};
    made.gaps = 2;
    made.journal.torn_bytes = 77;
    made.oldest_waiting_ns = 100 * kSecond;
    made.failure = "refused";
    return made;
}

TEST(OutputsReport, ALineForEachOutput) {
    const publish::OutputStatus outputs[] = {status(), status()};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = outputs_text(texts, outputs, 190 * kSecond);
        EXPECT_EQ(count_of(text, "\n"), 2U);
        expect_complete(text);
        for (const auto* part : {"cloud", "mqtts://broker.example:8883", "100", "25", "5", "refused"})
            expect_contains(text, part);
        expect_contains(text, texts("app.output.gaps", {{"count", "2"}}));
        expect_contains(text, texts("app.output.torn", {{"count", "77"}}));
        expect_contains(text,
                        texts("app.output.oldest", {{"age", texts.duration(std::chrono::seconds(90))}}));
    }
    EXPECT_EQ(outputs_text(english(), {}, 0), "");
}

TEST(OutputsReport, EveryStateHasItsWords) {
    using enum publish::OutputState;
    for (const auto state :
         {starting, connecting, delivering, falls_behind, waiting, stopped, ended, removed})
        for (const auto language : kLanguages) {
            auto one = status();
            one.state = state;
            one.journal_failure = Error{Code::io_failed, "journal", {28, 0, 0}};
            expect_complete(output_text(Texts(language), one, 0));
        }
}

TEST(OutputsReport, ADiskThatHangsAndSamplesThatAreTooLargeAreShown) {
    auto made = status();
    made.disk_waits = std::chrono::seconds(3);
    made.too_large = 4;
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = output_text(texts, made, 0);
        expect_contains(text,
                        texts("app.output.disk_waits", {{"age", texts.duration(std::chrono::seconds(3))}}));
        expect_contains(text, texts("app.output.too_large", {{"count", "4"}}));
    }
    EXPECT_JSON(*output_json(english(), made, 0).find("journal")->find("disk_waits_ms"), 3000.0);
}

TEST(OutputsReport, TroubleOfAnOutputShowsInTheHealth) {
    using Change = void (*)(publish::OutputStatus&);
    const auto health_with = [](const char* before, Change change) {
        auto made = status();
        change(made);
        auto answer = file::Json::object();
        answer.set("health", before);
        add_outputs(english(), answer, std::span(&made, 1), 0);
        EXPECT_TRUE(answer.find("outputs"));
        return std::get<std::string>(answer.find("health")->value());
    };
    EXPECT_EQ(health_with("ok", [](auto&) {}), "ok") << "a broker that is away";
    const Change troubles[] = {[](auto& its) { its.lost = 1; },
                               [](auto& its) { its.disk_waits = std::chrono::seconds(2); },
                               [](auto& its) { its.journal_failure = Error{Code::io_failed, "j", {28}}; },
                               [](auto& its) { its.state = publish::OutputState::stopped; }};
    for (const auto change : troubles) EXPECT_EQ(health_with("ok", change), "degraded");
    EXPECT_EQ(health_with("failed", troubles[0]), "failed");
}

TEST(OutputsReport, AnOutputThatFallsBehindNamesItsWindowAndARemedy) {
    auto made = status();
    made.state = publish::OutputState::falls_behind;
    made.failure.clear();
    made.behind_per_s = 640;
    made.remedies = "array,in_flight";
    made.mqtt = publish::MqttStatus{.window = 20, .round_trip = std::chrono::microseconds(100'300)};
    EXPECT_TRUE(
        output_text(english(), made, 0)
            .starts_with(
                "output cloud: falls behind: 640 more samples wait each second, window 20 × 100 ms, at "
                "mqtts://broker.example:8883, 100 samples delivered, 25 waiting"));
    const auto json = output_json(english(), made, 0);
    EXPECT_JSON(*json.find("state"), "falls_behind");
    EXPECT_JSON(*json.find("falls_behind")->find("samples_per_s"), 640U);
    EXPECT_JSON(*json.find("mqtt")->find("window"), 20U);
    EXPECT_JSON(*json.find("mqtt")->find("round_trip_ms"), 100.3);
    auto answer = file::Json::object();
    answer.set("health", "ok");
    add_outputs(english(), answer, std::span(&made, 1), 0);
    EXPECT_JSON(*answer.find("health"), "degraded");
    const auto text = problems_text(english(), *answer.find("problems"));
    for (const auto* part : {"falls behind: 640 more samples wait each second, window 20 × 100 ms",
                             "`backlog: array`", "`max_inflight_messages`", "journal"})
        expect_contains(text, part);
}

TEST(OutputsReport, JsonHasTheCountsAndTheOldest) {
    auto made = status();
    made.mqtt.emplace();
    made.mqtt->version = publish::MqttVersion::v5;
    const auto json = output_json(english(), made, 190 * kSecond);
    EXPECT_JSON(*json.find("sampled"), 130U);
    EXPECT_JSON(*json.find("waiting"), 25U);
    EXPECT_JSON(*json.find("gaps"), 2U);
    EXPECT_JSON(*json.find("journal")->find("torn_bytes"), 77U);
    EXPECT_JSON(*json.find("oldest_waiting"), "1970-01-01T00:01:40.000Z");
    EXPECT_JSON(*json.find("oldest_waiting_ms"), 90'000.0);
    EXPECT_JSON(*json.find("mqtt")->find("version"), "5");
    EXPECT_TRUE(json.find("journal")->find("failure")->is_null());
    made.oldest_waiting_ns.reset();
    EXPECT_TRUE(output_json(english(), made, 0).find("oldest_waiting")->is_null());
}

}  // namespace outputs_report_test
}  // namespace takt::report
