// Streams, their deadlines, even rounds and the longest of them, on requests made by hand.
#include "timing/streams.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "builder.hpp"

namespace takt::plan {
namespace streams_test {

using namespace test;

Request polled(std::vector<std::size_t> variables, Duration period, Duration phase = 0ms,
               Duration bus_time = 10ms) {
    Request request;
    request.read = wire::Function::read_holding_registers;
    request.variables = std::move(variables);
    request.period = period;
    request.phase = phase;
    request.bus_time = bus_time;
    return request;
}

// A line with two devices of so many variables, all with that period.
model::Line line_of(std::size_t variables, Duration period) {
    const std::vector<Item> items(variables, int16(0).read(3).every(period));
    auto made = project({}, {}).lines[0];
    made.devices = {device(1, {}, items), device(2, {}, items)};
    return made;
}

std::vector<std::size_t> streams_of(const std::vector<Request>& requests) {
    std::vector<std::size_t> streams;
    for (const auto& request : requests) streams.push_back(request.stream);
    return streams;
}

std::vector<std::optional<Duration>> deadlines_of(const std::vector<Request>& requests) {
    std::vector<std::optional<Duration>> deadlines;
    for (const auto& request : requests) deadlines.push_back(request.deadline);
    return deadlines;
}

TEST(Streams, AreRequestsThatShareVariables) {
    std::vector<Request> requests{polled({0, 1}, 200ms, 100ms), polled({2}, 400ms), polled({1, 3}, 500ms),
                                  polled({3}, 1000ms), polled({4}, 50ms)};
    auto line = line_of(5, 500ms);
    line.devices[0].variables[2].period = 400ms;
    line.devices[0].variables[3].deadline = 70ms;
    line.devices[0].variables[4].period = 50ms;
    number_streams(line, requests);
    EXPECT_EQ(streams_of(requests), (std::vector<std::size_t>{0, 1, 0, 0, 2}));
    const std::vector<std::optional<Duration>> least{70ms, 400ms, 70ms, 70ms, 50ms};
    EXPECT_EQ(deadlines_of(requests), least);
}

TEST(Streams, AreOfOneDevice) {
    std::vector<Request> requests{polled({0}, 200ms), polled({0}, 400ms)};
    requests[1].device = 1;
    auto line = line_of(1, 200ms);
    line.devices[1].variables[0].period = 400ms;
    number_streams(line, requests);
    EXPECT_EQ(streams_of(requests), (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(deadlines_of(requests), (std::vector<std::optional<Duration>>{200ms, 400ms}));
}

TEST(Streams, LeaveOutWhatIsNotPolledWithAPeriod) {
    std::vector<Request> requests{polled({0}, 200ms), polled({0}, 0ms), polled({0}, 100ms)};
    requests[2].period.reset();
    requests[2].read_trigger = 0;
    auto write = polled({0}, 100ms);
    write.read.reset();
    write.period.reset();
    write.deadline = 30ms;
    requests.push_back(write);
    number_streams(line_of(1, 50ms), requests);
    EXPECT_EQ(streams_of(requests), (std::vector<std::size_t>{0, 1, 2, 3}));
    const std::vector<std::optional<Duration>> kept{50ms, std::nullopt, std::nullopt, 30ms};
    EXPECT_EQ(deadlines_of(requests), kept);
}

// ---- spreading

std::vector<Duration> phases_of(const std::vector<Request>& requests) {
    std::vector<Duration> phases;
    for (const auto& request : requests) phases.push_back(request.phase);
    return phases;
}

std::vector<Request> spread_out(const model::Line& line, std::vector<Request> requests,
                                std::vector<bool> movable = {true, true}) {
    number_streams(line, requests);
    spread(line, movable, requests);
    return requests;
}

TEST(Spreading, MakesRoundsEven) {
    auto line = line_of(11, 1000ms);
    line.devices[0].variables[0].period = 100ms;
    std::vector<Request> requests{polled({0}, 100ms)};
    for (std::size_t v = 1; v <= 10; ++v) requests.push_back(polled({v}, 1000ms));
    auto phases = phases_of(spread_out(line, requests));
    EXPECT_EQ(phases.front(), 0ms);
    std::sort(phases.begin() + 1, phases.end());
    for (int i = 0; i < 10; ++i) EXPECT_EQ(phases[static_cast<std::size_t>(i) + 1], i * 100ms);
}

TEST(Spreading, KeepsOnePeriodTogether) {
    const auto requests = spread_out(line_of(3, 1000ms), {polled({0}, 1000ms), polled({1}, 1000ms)});
    EXPECT_EQ(phases_of(requests), (std::vector<Duration>{0ms, 0ms}));
}

TEST(Spreading, LeavesOtherDevicesWhereTheyAre) {
    auto line = line_of(3, 1000ms);
    line.devices[0].variables[0].period = 100ms;
    std::vector<Request> requests{polled({0}, 100ms), polled({1}, 1000ms), polled({1}, 1000ms),
                                  polled({2}, 1000ms)};
    requests[2].device = requests[3].device = 1;
    const auto spread = spread_out(line, requests, {true, false});
    EXPECT_EQ(phases_of(spread), (std::vector<Duration>{0ms, 100ms, 0ms, 0ms}));
}

// All of a stream moves by the same time, round the clock.
TEST(Spreading, MovesWholeStreams) {
    auto line = line_of(4, 300ms);
    line.devices[0].variables[0].period = 100ms;
    const std::vector<Request> requests{polled({0}, 100ms), polled({1}, 300ms, 0ms, 30ms),
                                        polled({2, 3}, 300ms, 0ms, 20ms), polled({2}, 300ms, 100ms, 5ms),
                                        polled({2}, 300ms, 200ms, 5ms)};
    const auto spread = spread_out(line, requests);
    EXPECT_EQ(phases_of(spread), (std::vector<Duration>{0ms, 0ms, 100ms, 200ms, 0ms}));
}

// ---- anything at all

struct Sample {
    model::Line line = line_of(6, 1000ms);
    std::vector<Request> requests;
};

Sample sample() {
    Sample made;
    const auto count = *rc::gen::inRange(1, 9);
    for (int i = 0; i < count; ++i) {
        const auto variable = *rc::gen::inRange<std::size_t>(0, 6);
        const auto period = *rc::gen::element(100ms, 150ms, 200ms, 500ms, 1000ms) * *rc::gen::inRange(1, 3);
        const auto phase = *rc::gen::inRange(0, 10) * period / 10;
        auto request = polled({variable}, period, phase, *rc::gen::inRange(1, 20) * 1ms);
        request.device = *rc::gen::inRange<std::size_t>(0, 2);
        made.line.devices[request.device].variables[variable].period = period;
        made.requests.push_back(request);
    }
    number_streams(made.line, made.requests);
    return made;
}

// All instants of a stream's requests, in the order of the requests, before they come again.
std::map<std::size_t, std::vector<std::set<std::int64_t>>> instants(const std::vector<Request>& requests,
                                                                    Duration shift = 0ms) {
    std::int64_t repeats = 1;
    for (const auto& request : requests) repeats = std::lcm(repeats, request.period->count());
    std::map<std::size_t, std::vector<std::set<std::int64_t>>> all;
    for (const auto& request : requests) {
        auto& own = all[request.stream].emplace_back();
        for (auto t = request.phase.count(); t < repeats; t += request.period->count())
            own.insert((t + shift.count()) % repeats);
    }
    return all;
}

RC_GTEST_PROP(Spreading, ShiftsEachStreamAsOne, ()) {
    const auto made = sample();
    auto spread_requests = made.requests;
    spread(made.line, {true, true}, spread_requests);
    auto fastest = Duration::max();
    for (const auto& request : made.requests) {
        const auto& device = made.line.devices[request.device];
        for (const auto v : request.variables) fastest = std::min(fastest, device.variables[v].period);
    }
    for (const auto& request : spread_requests)
        RC_ASSERT(request.phase >= 0ms && request.phase < *request.period);
    const auto after = instants(spread_requests);
    for (const auto& [stream, expected] : after) {
        bool found = false;
        for (int k = 0; k < 1024 && !found; ++k)
            found = instants(made.requests, k * fastest).at(stream) == expected;
        RC_ASSERT(found);
    }
}

Duration bus_time_due(const std::vector<Request>& requests, Duration t) {
    Duration sum{};
    for (const auto& request : requests)
        if (t >= request.phase && (t - request.phase) % *request.period == 0ms) sum += request.bus_time;
    return sum;
}

RC_GTEST_PROP(LongestRound, IsTheFullestInstant, ()) {
    const auto requests = sample().requests;
    Duration longest{};
    for (auto t = 0ms; t < 12000ms; t += 5ms) longest = std::max(longest, bus_time_due(requests, t));
    Duration found{};
    for (const auto i : longest_round(requests)) found += requests[i].bus_time;
    RC_ASSERT(found == longest);
}

TEST(LongestRound, HasWhatIsAlwaysDue) {
    std::vector<Request> requests{polled({0}, 100ms, 0ms, 5ms), polled({1}, 100ms, 50ms, 9ms),
                                  polled({2}, 0ms, 0ms, 1ms)};
    EXPECT_EQ(longest_round(requests), (std::vector<std::size_t>{1, 2}));
    EXPECT_TRUE(longest_round({}).empty());
}

// A hyperperiod of 97 * 101 * 103 * 107 ms: of each stream the longest.
TEST(LongestRound, IsBoundedWhereItCannotBeCounted) {
    std::vector<Request> requests;
    for (const auto period : {97ms, 101ms, 103ms, 107ms})
        requests.push_back(polled({requests.size()}, period, 1ms));
    requests.push_back(polled({3}, 107ms, 2ms, 4ms));
    number_streams(line_of(4, 97ms), requests);
    EXPECT_EQ(longest_round(requests), (std::vector<std::size_t>{0, 1, 2, 3}));
}

}  // namespace streams_test
}  // namespace takt::plan
