#include "takt/capture/latency.hpp"

#include <gtest/gtest.h>

#include "capture_bytes.hpp"
#include "takt/capture/analysis.hpp"

namespace takt::capture {
namespace latency_test {

using namespace test;
using namespace std::chrono_literals;

ObservedRequest request_at(std::int64_t time_ns, std::uint8_t unit = 1, std::uint32_t items = 0) {
    return {.route = {.client = {*parse_ip("10.0.0.1"), 40000}, .server = {*parse_ip("10.0.0.2"), 502}},
            .unit = unit,
            .function = 3,
            .items = items,
            .packet = {static_cast<std::uint64_t>(time_ns / 1000 + 1), time_ns}};
}

void exchange(LatencyReport& report, const ObservedRequest& request, Duration time,
              std::uint8_t exception = 0) {
    report.on_request(request);
    report.on_response(request, {.packet = {request.packet.number + 1, request.packet.time_ns + time.count()},
                                 .exception = exception});
}

/// The five exchanges of the source (docs/specification.md, section 10), as a capture.
TEST(Latency, ReproducesTheFiguresOfTheSource) {
    constexpr Duration kTimes[] = {205us, 146us, 148us, 152us, 149us};
    std::vector<TimedPacket> packets;
    std::int64_t at = 1'700'000'000'000'000'000;
    std::uint32_t sent = 1;
    std::uint32_t received = 1;
    for (std::uint16_t i = 0; i < 5; ++i, at += 1'000'000'000) {
        packets.push_back(
            {at, ipv4({.sequence = sent, .acknowledged = received}, adu(i, 1, "03 006B 0001"))});
        sent += 12;
        packets.push_back({at + kTimes[i].count(), ipv4({.from = 2,
                                                         .to = 1,
                                                         .from_port = 502,
                                                         .to_port = 40000,
                                                         .sequence = received,
                                                         .acknowledged = sent},
                                                        adu(i, 1, "03 02 0001"))});
        received += 11;
    }
    LatencyReport report({.limit = 1ms});
    Analysis analysis({}, 1s, report);
    CaptureReader reader(analysis);
    ASSERT_TRUE(feed(reader, pcap(LinkType::raw, packets, false)));
    analysis.end();
    report.end(analysis.packets().last_ns);
    const auto& total = report.total();
    EXPECT_EQ(total.answered, 5u);
    EXPECT_EQ(total.exceeded, 0u);
    EXPECT_EQ(total.times.min(), 146us);
    EXPECT_EQ(total.times.max(), 205us);
    EXPECT_EQ(total.times.mean(), 160us);
    EXPECT_EQ(total.times.percentile(50), 149us);
    EXPECT_EQ(total.times.percentile(99), 205us);
    EXPECT_EQ(total.mean_interval(), 1s);
    EXPECT_EQ(total.jitter.max(), 0s);
    const auto slowest = report.slowest();
    ASSERT_EQ(slowest.size(), 5u);
    EXPECT_EQ(slowest[0].time(), 205us);
    EXPECT_EQ(slowest[0].request.packet.number, 1u);
    EXPECT_EQ(slowest[1].time(), 152us);
    EXPECT_EQ(slowest[1].request.packet.number, 7u);
}

TEST(Latency, CountsBySeriesAndInTotal) {
    LatencyReport report({.timeout = 100ms, .limit = 1ms});
    exchange(report, request_at(0, 1), 500us);
    exchange(report, request_at(10'000, 1), 2ms, 2);
    exchange(report, request_at(20'000, 2), 150ms);
    const auto lost = request_at(30'000, 2);
    report.on_request(lost);
    report.on_no_response(lost, NoResponse::unanswered);
    const auto old = request_at(40'000, 2);
    report.on_request(old);
    report.on_no_response(old, NoResponse::end);
    const auto young = request_at(150'000'000, 2);
    report.on_request(young);
    report.on_no_response(young, NoResponse::end);
    report.end(200'000'000);
    ASSERT_EQ(report.series().size(), 2u);
    const auto& [first_key, first] = report.series()[0];
    EXPECT_EQ(first_key.unit, 1);
    EXPECT_EQ(first->answered, 2u);
    EXPECT_EQ(first->exceptions.at(2), 1u);
    EXPECT_EQ(first->exceeded, 1u);
    const auto& second = *report.series()[1].second;
    EXPECT_EQ(second.requests, 4u);
    EXPECT_EQ(second.late, 1u);
    EXPECT_EQ(second.unanswered, 2u);
    EXPECT_EQ(second.open, 1u);
    EXPECT_EQ(second.exceeded, 3u);
    const auto& total = report.total();
    EXPECT_EQ(total.requests, 6u);
    EXPECT_EQ(total.decided(), 5u);
    EXPECT_EQ(total.exceeded, 4u);
}

TEST(Latency, GroupsByWhatIsWanted) {
    const auto series_with = [](const Grouping& grouping) {
        LatencyReport report({.grouping = grouping});
        for (std::uint8_t unit = 1; unit <= 3; ++unit) {
            auto request = request_at(unit * 1000, unit);
            request.route.client.address.bytes[15] = unit;
            exchange(report, request, 1ms);
        }
        return report.series().size();
    };
    EXPECT_EQ(series_with({}), 3u);
    EXPECT_EQ(series_with({.client = false}), 3u);
    EXPECT_EQ(series_with({.client = false, .unit = false}), 1u);
    EXPECT_EQ(series_with({.unit = false}), 3u);
}

TEST(Latency, JitterOfEachPollByItself) {
    LatencyReport report({});
    // Two polls of 10 and 15 ms; the third interval of the first one is 2 ms longer.
    for (const std::int64_t ms : {0, 10, 20, 32}) exchange(report, request_at(ms * 1'000'000, 1, 1), 1us);
    for (const std::int64_t ms : {1, 16, 31}) exchange(report, request_at(ms * 1'000'000, 1, 2), 1us);
    const auto& total = report.total();
    EXPECT_EQ(total.intervals, 5u);
    EXPECT_EQ(total.mean_interval(), 12400us);
    EXPECT_EQ(total.jitter.count(), 3u);
    EXPECT_EQ(total.jitter.max(), 2ms);
    EXPECT_EQ(total.jitter.percentile(50), 0s);
}

TEST(Latency, PercentilesOfManyAreWithinTheirPrecision) {
    MeasuredTimes times;
    for (int i = 1; i <= 100'000; ++i) times.record(Duration(i * 1000));
    EXPECT_EQ(times.min(), 1us);
    EXPECT_EQ(times.max(), 100ms);
    for (const double percent : {50.0, 90.0, 99.0, 99.9, 99.99}) {
        const auto exact = static_cast<double>(percent * 1'000'000);
        const auto measured = static_cast<double>(times.percentile(percent).count());
        EXPECT_GE(measured, exact);
        EXPECT_LE(measured, exact * (1 + 1.0 / 128));
    }
}

TEST(Latency, SeriesBeyondTheLimitCountTogether) {
    LatencyReport report({});
    constexpr std::size_t kMore = 5;
    for (std::size_t i = 0; i < LatencyReport::kMostSeries + kMore; ++i) {
        auto request = request_at(static_cast<std::int64_t>(i) * 1000);
        request.route.client.address.bytes[14] = static_cast<std::uint8_t>(i >> 8);
        request.route.client.address.bytes[13] = static_cast<std::uint8_t>(i);
        exchange(report, request, 1ms);
    }
    EXPECT_EQ(report.series().size(), LatencyReport::kMostSeries);
    EXPECT_EQ(report.others().answered, kMore);
    EXPECT_EQ(report.total().answered, LatencyReport::kMostSeries + kMore);
}

TEST(Latency, CountsMicroseconds) {
    LatencyReport report({.microsecond_buckets = 3});
    for (const auto time : {0ns, 999ns, 1000ns, 2999ns, 3000ns}) exchange(report, request_at(0), time);
    EXPECT_EQ(report.microseconds(), (std::vector<std::uint64_t>{2, 1, 1}));
    EXPECT_EQ(report.overflows(), 1u);
}

TEST(Latency, KeepsTheTenSlowest) {
    LatencyReport report({});
    for (int i = 0; i < 100; ++i)
        exchange(report, request_at(i * 1'000'000), Duration(1000 * ((i * 37) % 100)));
    const auto slowest = report.slowest();
    ASSERT_EQ(slowest.size(), 10u);
    for (std::size_t i = 0; i < 10; ++i)
        EXPECT_EQ(slowest[i].time(), Duration(1000 * (99 - static_cast<int>(i))));
}

TEST(Latency, RequestsThatWereNotSentAreUnanswered) {
    LatencyReport report({.limit = 1ms});
    exchange(report, request_at(0), 500us);
    report.on_unsent(request_at(1'000'000), 7);
    report.on_unsent(request_at(1'000'000), 0);
    const Series* const both[] = {&report.total(), report.series()[0].second.get()};
    for (const auto* const series : both) {
        EXPECT_EQ(series->requests, 8u);
        EXPECT_EQ(series->unanswered, 7u);
        EXPECT_EQ(series->exceeded, 7u);
        EXPECT_EQ(series->decided(), 8u);
    }
}

}  // namespace latency_test
}  // namespace takt::capture
