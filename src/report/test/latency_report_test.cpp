#include "takt/report/times/latency_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "sample.hpp"
#include "takt/report/times/latency_svg.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::report {
namespace latency_report_test {

using namespace test;
using namespace std::chrono_literals;

constexpr std::int64_t kStart = 1'790'000'000'000'000'000;  // 2026-09-21T14:13:20Z

capture::ObservedRequest request_of(std::uint64_t number, std::uint8_t unit) {
    return {.route = {.client = {*parse_ip("10.0.0.1"), 40000}, .server = {*parse_ip("10.0.0.2"), 502}},
            .unit = unit,
            .function = 3,
            .packet = {number, kStart + static_cast<std::int64_t>(number) * 1'000'000}};
}

/// Exchanges with these times, of the units 1 and 2 in turn.
capture::LatencyReport report_of(const std::vector<Duration>& times, const capture::LatencyConfig& config) {
    capture::LatencyReport report(config);
    std::uint64_t number = 1;
    for (const auto time : times) {
        const auto request = request_of(number, static_cast<std::uint8_t>(1 + number / 2 % 2));
        report.on_request(request);
        report.on_response(request, {.packet = {number + 1, request.packet.time_ns + time.count()}});
        number += 2;
    }
    return report;
}

LatencyRun run_of(const capture::LatencyReport& report) {
    return {.file = "plant.pcapng",
            .report = report,
            .packets = {.packets = 10, .first_ns = kStart, .last_ns = kStart + 10'000'000},
            .tcp = {.unmatched = 7}};
}

const std::vector<Duration> kSource{205us, 146us, 148us, 152us, 149us};

TEST(LatencyReport, TextInEveryLanguage) {
    const auto report = report_of(kSource, {.limit = 1ms});
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = latency_text(texts, run_of(report), SIZE_MAX);
        expect_complete(text);
        for (const auto* part : {"0.205", "0.146", "0.160", "0.149", "10.0.0.1", "10.0.0.2:502", "0x03"})
            EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
        EXPECT_NE(text.find(texts("app.latency.note.unmatched", {{"count", "7"}})), std::string::npos);
        EXPECT_NE(text.find(latency_verdict_text(texts, report)), std::string::npos);
        EXPECT_EQ(latency_svg(texts, run_of(report)).find("app."), std::string::npos);
    }
}

TEST(LatencyReport, VerdictInWords) {
    const auto words = [](std::size_t fast, std::size_t slow) {
        std::vector<Duration> times(fast, 100us);
        times.insert(times.end(), slow, 2ms);
        return latency_verdict_text(english(), report_of(times, {.limit = 1ms}));
    };
    EXPECT_EQ(
        words(99'000, 0),
        "Limit 1 ms: kept. None of 99,000 exchanges exceeded it. With 95 % confidence fewer than 1 in 33,000 "
        "exceed 1 ms.");
    EXPECT_EQ(words(5, 0),
              "Limit 1 ms: kept. None of 5 exchanges exceeded it. With 95 % confidence fewer than 46 % "
              "exceed 1 ms.");
    // 4 of 20,000: the upper bound of Clopper and Pearson is 4.6 of 10,000.
    EXPECT_EQ(
        words(19'996, 4),
        "Limit 1 ms: not kept. 4 of 20,000 exchanges exceeded it. With 95 % confidence fewer than 1 in 2,100 "
        "exceed 1 ms.");
    EXPECT_EQ(words(0, 2), "Limit 1 ms: not kept. 2 of 2 exchanges exceeded it.");
    EXPECT_EQ(words(0, 0), "Limit 1 ms: not decided, because there is no exchange.");
}

TEST(LatencyReport, Json) {
    const auto report = report_of(kSource, {.limit = 1ms});
    const auto json = latency_json(english(), run_of(report));
    const auto& total = *json.find("total");
    EXPECT_JSON(*total.find("answered"), 5);
    EXPECT_JSON(*total.find("min_ms"), 0.146);
    EXPECT_JSON(*total.find("mean_ms"), 0.16);
    EXPECT_JSON(*total.find("p50_ms"), 0.149);
    EXPECT_JSON(*total.find("p99.99_ms"), 0.205);
    EXPECT_JSON(*total.find("exceeded"), 0);
    const auto& series = std::get<file::Json::Array>(json.find("series")->value());
    ASSERT_EQ(series.size(), 2u);
    EXPECT_JSON(*series[0].find("client"), "10.0.0.1");
    EXPECT_JSON(*series[0].find("server"), "10.0.0.2:502");
    const auto& verdict = *json.find("verdict");
    EXPECT_JSON(*verdict.find("kept"), true);
    EXPECT_JSON(*verdict.find("exchanges"), 5);
    const auto& slowest = std::get<file::Json::Array>(json.find("slowest")->value());
    ASSERT_EQ(slowest.size(), 5u);
    EXPECT_JSON(*slowest[0].find("request_packet"), 1);
    EXPECT_JSON(*slowest[0].find("client"), "10.0.0.1:40000");
    EXPECT_JSON(*json.find("capture")->find("unmatched_responses"), 7);
    EXPECT_EQ(std::get<file::Json::Array>(json.find("histogram")->value()).size(), 5u);
}

TEST(LatencyReport, PacketsWithoutATimeHaveNoFirstAndLast) {
    const auto report = report_of({}, {});
    auto run = run_of(report);
    run.packets = {.packets = 10, .untimed = 10};
    const auto json = latency_json(english(), run);
    EXPECT_TRUE(json.find("capture")->find("first")->is_null());
    EXPECT_TRUE(json.find("capture")->find("last")->is_null());
}

TEST(LatencyReport, CsvHasEqualColumns) {
    const auto report = report_of({1ms, 2ms, 3ms, 4ms, 5ms, 6ms}, {.grouping = {.client = false}});
    const auto text = latency_csv(report);
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
        lines.push_back(text.substr(at, text.find('\n', at) - at));
    ASSERT_EQ(lines.size(), 4u);
    for (const auto& line : lines)
        EXPECT_EQ(std::ranges::count(line, ','), std::ranges::count(lines[0], ',')) << line;
    EXPECT_TRUE(lines[1].starts_with(",10.0.0.2:502,1,3,3,3,,0,")) << lines[1];
    EXPECT_TRUE(lines[3].starts_with("total,,,,6,6,")) << lines[3];
}

TEST(LatencyReport, HistogramOfCyclictest) {
    const auto report = report_of({0us, 1us, 1us, 7us}, {.microsecond_buckets = 3});
    EXPECT_EQ(latency_histogram(report),
              "# Histogram\n000000 000001\n000001 000002\n000002 000000\n# Total: 000000003\n"
              "# Min Latencies: 00000\n# Avg Latencies: 00002\n# Max Latencies: 00007\n"
              "# Histogram Overflows: 00001\n");
}

TEST(LatencyReport, PictureShowsEveryExchange) {
    std::vector<Duration> times(1000, 100us);
    times.push_back(3ms);
    const auto report = report_of(times, {.limit = 1ms});
    const auto text = latency_svg(english(), run_of(report));
    EXPECT_NE(text.find(" data-count=\"1000\""), std::string::npos);
    EXPECT_NE(text.find(" data-count=\"1\""), std::string::npos);
    EXPECT_NE(text.find("class=\"limit\""), std::string::npos);
    EXPECT_EQ(text.find("nan"), std::string::npos);
    const auto empty = latency_svg(english(), run_of(report_of({}, {})));
    EXPECT_EQ(empty.find("nan"), std::string::npos);
}

/// A load whose three responses took 1 ms from sending, and 1, 2 and 3 ms from the due instant.
struct MeasuredLoad {
    explicit MeasuredLoad(const std::optional<client::Rate>& rate) {
        options.request =
            *wire::prepare(wire::ReadRequest{wire::Function::read_holding_registers, DataAddress{10}, 5});
        options.rate = rate;
        options.same_content = true;
        counts.sent = 3;
        counts.unsent = 4;
        counts.timed_out = 5;
        counts.wrong = 6;
        counts.lost = 7;
        counts.different = 8;
        counts.disconnections = 9;
        counts.begin_ns = kStart;
        counts.elapsed = 2s;
        for (int i = 0; i < 3; ++i) counts.from_sending.record(1ms);
    }
    [[nodiscard]] LatencyRun run() const {
        return {.file = "tcp://h:502",
                .report = report,
                .packets = {.first_ns = kStart, .last_ns = kStart + 2'000'000'000},
                .tcp = {},
                .serial = {},
                .load = LoadRun{options, counts}};
    }
    client::LoadOptions options;
    client::LoadCounts counts;
    capture::LatencyReport report = report_of({1ms, 2ms, 3ms}, {.grouping = {false, false}, .limit = 10ms});
};

TEST(LatencyReport, ALoadStatesBothTimes) {
    const MeasuredLoad load(client::Rate{3000, std::chrono::minutes(1)});
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = latency_text(texts, load.run(), SIZE_MAX);
        expect_complete(text);
        for (const auto* const part : {"tcp://h:502", "0x03 10..14", "3000/min", "3.000"})
            EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
        EXPECT_NE(text.find(texts("app.latency.load.from_sending")), std::string::npos);
        for (const auto& [note, count] :
             {std::pair{"unsent", "4"}, std::pair{"timed_out", "5"}, std::pair{"wrong", "6"},
              std::pair{"lost", "7"}, std::pair{"different", "8"}, std::pair{"disconnections", "9"}})
            EXPECT_NE(text.find(texts(std::string("app.latency.load.note.") + note, {{"count", count}})),
                      std::string::npos)
                << note;
        EXPECT_EQ(latency_svg(texts, load.run()).find("app."), std::string::npos);
    }
    const auto json = latency_json(english(), load.run());
    EXPECT_EQ(json.find("capture"), nullptr);
    EXPECT_JSON(*json.find("target"), "tcp://h:502");
    const auto& section = *json.find("load");
    EXPECT_JSON(*section.find("rate_per_s"), 50.0);
    EXPECT_JSON(*section.find("coordinated_omission"), "avoided");
    EXPECT_JSON(*section.find("sent_per_s"), 1.5);
    EXPECT_JSON(*section.find("unsent"), 4);
    EXPECT_JSON(*section.find("from_sending")->find("max_ms"), 1.0);
    EXPECT_JSON(*json.find("total")->find("max_ms"), 3.0);
    EXPECT_JSON(*std::get<file::Json::Array>(json.find("slowest")->value())[0].find("request"), 5);
}

TEST(LatencyReport, ALoadGivesTheRoundTripOfAProject) {
    MeasuredLoad load(std::nullopt);
    load.options.in_flight = 4;
    for (int i = 0; i < 97; ++i) load.counts.from_sending.record(2'000'500ns);
    EXPECT_FALSE(round_trip_of(load.run())) << "some requests had no response";
    load.counts.timed_out = load.counts.wrong = load.counts.lost = 0;
    EXPECT_EQ(round_trip_of(load.run()), (model::MeasuredRoundTrip{2'001us, 2'001us, 100, 4}));
    const auto json = latency_json(english(), load.run());
    const auto& round_trip = *json.find("load")->find("round_trip");
    EXPECT_JSON(*round_trip.find("longest"), "2001us");
    EXPECT_JSON(*round_trip.find("exchanges"), 100);
    EXPECT_NE(latency_text(english(), load.run(), SIZE_MAX)
                  .find("round_trip: {longest: 2001us, usual: 2001us, exchanges: 100, in_flight: 4}"),
              std::string::npos);
    load.options.connections = 2;
    EXPECT_FALSE(round_trip_of(load.run()));
    load.options.connections = 1;
    auto serial = load.run();
    serial.file = "rtu:///dev/ttyS0";
    EXPECT_FALSE(round_trip_of(serial));
}

TEST(LatencyReport, ALoadWithoutARateStatesThatResponsesDelayRequests) {
    const MeasuredLoad load(std::nullopt);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_NE(latency_text(texts, load.run(), SIZE_MAX).find(texts("app.latency.load.closed")),
                  std::string::npos);
    }
    const auto json = latency_json(english(), load.run());
    EXPECT_TRUE(json.find("load")->find("rate_per_s")->is_null());
    EXPECT_JSON(*json.find("load")->find("coordinated_omission"), "possible");
}

TEST(LatencyReport, FaultsNamePlaceValueAndAllowed) {
    using enum capture::CaptureFault;
    for (const auto fault : {empty, not_a_capture, compressed, version, byte_order, record_length,
                             record_too_short, length_differs, interface, resolution, incomplete})
        for (const auto language : kLanguages) {
            const auto text =
                capture_error_text(Texts(language), "a.pcap",
                                   {.fault = fault, .offset = 1234, .packet = 5, .value = 77, .allowed = 66});
            expect_complete(text);
            EXPECT_TRUE(text.starts_with("a.pcap: ")) << text;
        }
    EXPECT_EQ(capture_error_text(english(), "a.pcap",
                                 {.fault = interface, .offset = 28, .packet = 3, .value = 2, .allowed = 1}),
              "a.pcap: byte 28, after packet 3: interface 2; interfaces of the section: 1");
}

TEST(LatencyReport, Endpoints) {
    EXPECT_EQ(endpoint_text({*parse_ip("10.0.0.2"), 502}), "10.0.0.2:502");
    EXPECT_EQ(endpoint_text({*parse_ip("fe80::1"), 502}), "[fe80::1]:502");
    EXPECT_EQ(endpoint_text({*parse_ip("fe80::1"), 0}), "fe80::1");
    EXPECT_EQ(grouped_number(1'234'567, text::Language::english), "1,234,567");
    EXPECT_EQ(grouped_number(999, text::Language::english), "999");
}

}  // namespace latency_report_test
}  // namespace takt::report
