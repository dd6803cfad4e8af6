// Exchanges, statistics, masters and the project of a heard line.
#include "takt/capture/line_listener.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "hex.hpp"
#include "takt/capture/heard_project.hpp"

namespace takt::capture {
namespace line_listener_test {

using namespace std::chrono_literals;
using takt::test::from_hex;
using takt::test::to_hex;

struct Kept final : ListenObserver {
    std::string text;
    void on_exchange(const Exchange& exchange) override {
        constexpr const char* kOutcomes[] = {"A", "X", "U", "B", "O"};
        text += kOutcomes[static_cast<int>(exchange.outcome)] + std::to_string(exchange.request.unit);
        if (!exchange.response.empty()) text += "/" + std::to_string(exchange.response_time / 1ms);
        if (exchange.request.overlaps) text += '!';
        if (exchange.request.repeats) text += '=';
        text += ' ';
    }
    void on_stray(const LineFrame& frame) override { text += "S" + std::to_string(frame.unit) + ' '; }
    void on_damaged(const DamagedBytes&) override { text += "D "; }
};

constexpr Instant at(Duration t) {
    return Instant(t);
}

class Line {
public:
    void send(Duration t, std::uint8_t unit, std::string_view pdu) {
        const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{unit}, 0, from_hex(pdu));
        listener.on_bytes(at(t), frame.span());
    }
    void exchange(Duration t, std::uint8_t unit, std::string_view request, std::string_view response,
                  Duration time = 5ms) {
        send(t, unit, request);
        send(t + time, unit, response);
    }
    Kept kept;
    LineListener listener{{}, kept};
};

TEST(LineListener, ReportsExchanges) {
    Line line;
    line.exchange(0ms, 1, "03 0000 0001", "03 02 0001");
    line.exchange(100ms, 2, "06 0000 0001", "06 0000 0001", 8ms);
    line.exchange(200ms, 1, "03 0000 0001", "83 02");
    line.send(300ms, 0, "06 0000 0001");
    line.send(400ms, 3, "03 0000 0001");
    line.send(500ms, 3, "03 0000 0001");
    line.listener.on_tick(at(1499ms));
    EXPECT_EQ(line.kept.text, "A1/5 A2/8 X1/5 B0 U3 ");
    EXPECT_EQ(line.listener.next_wakeup(), at(1500ms));
    line.listener.on_tick(at(1500ms));
    line.send(1600ms, 3, "03 02 0001");
    line.send(1700ms, 1, "03 0000 0001");
    line.listener.end();
    EXPECT_EQ(line.kept.text, "A1/5 A2/8 X1/5 B0 U3 U3= S3 O1 ");
    const auto& counts = line.listener.statistics().counts();
    EXPECT_EQ(counts.requests, 7U);
    EXPECT_EQ(counts.responses, 3U);
    EXPECT_EQ(counts.unanswered, 2U);
    EXPECT_EQ(counts.open, 1U);
    EXPECT_EQ(counts.broadcasts, 1U);
    EXPECT_EQ(counts.strays, 1U);
    EXPECT_EQ(line.listener.statistics().devices().at(3).polls[0].repeats, 1U);
}

TEST(LineListener, ShowsOverlapsAndDamage) {
    Line line;
    line.exchange(0ms, 1, "03 0000 0001", "03 02 0001", 20ms);
    line.send(100ms, 1, "03 0000 0001");
    line.send(105ms, 2, "03 0000 0001");
    const auto damaged = from_hex("01 03 02 00 07 00 00");
    line.listener.on_bytes(at(120ms), damaged);
    line.listener.on_tick(at(200ms));
    EXPECT_EQ(line.kept.text, "A1/20 D ");
    line.listener.on_tick(at(2s));
    EXPECT_EQ(line.kept.text, "A1/20 D U1 U2! ");
    EXPECT_EQ(line.listener.statistics().counts().overlaps, 1U);
    EXPECT_EQ(line.listener.statistics().counts().damaged_bytes, 7U);
}

TEST(LineListener, ADeviceThatWasAskedInVainIsSilent) {
    Line line;
    for (int i = 0; i < 4; ++i) {
        line.exchange(i * 1s, 1, "03 0000 0001", "03 02 0001");
        line.send(i * 1s + 100ms, 2, "03 0000 0001");
    }
    line.listener.on_tick(at(10s));
    EXPECT_FALSE(line.listener.statistics().devices().at(1).silent());
    const auto& silent = line.listener.statistics().devices().at(2);
    EXPECT_TRUE(silent.silent());
    EXPECT_EQ(silent.polls[0].repeats, 0U) << "other requests came between";
    EXPECT_EQ(silent.polls[0].period().median, 1s);
    EXPECT_EQ(line.listener.statistics().devices().at(1).times.max(), 5ms);
}

TEST(LineListener, ARequestAfterItsTimeOutIsARepetition) {
    Line line;
    for (int cycle = 0; cycle < 5; ++cycle) {
        const Duration begin = cycle * 10s;
        for (const auto attempt : {0ms, 1100ms, 2200ms}) line.send(begin + attempt, 3, "03 0000 0001");
        line.listener.on_tick(begin + 4s + Instant());
    }
    const auto& poll = line.listener.statistics().devices().at(3).polls[0];
    EXPECT_EQ(poll.repeats, 10U);
    EXPECT_EQ(poll.unanswered, 15U);
    EXPECT_EQ(poll.period().median, 10s) << "repetitions are no polls";
}

TEST(LineListener, TakesWholeFramesOfACapture) {
    Kept kept;
    LineListener listener({}, kept);
    listener.on_captured(at(0ms), from_hex("01 04 00 00 00 02 71 CB"));
    listener.on_captured(at(3ms), from_hex("01 04 04 00 02 00 03 1A 45"));
    listener.on_captured(at(5ms), from_hex("01 04 04"));
    EXPECT_EQ(kept.text, "A1/3 D ");
}

/// Polls of a master: each cycle the requests follow each other in 7 ms.
struct Master {
    Duration cycle;
    std::vector<std::pair<std::uint8_t, std::uint8_t>> polls;  // unit, register
};

/// Sends the polls of all masters in the order of their times.
void play(Line& line, const std::vector<Master>& masters, Duration length) {
    std::multimap<Duration, std::pair<std::uint8_t, std::uint8_t>> due;
    for (const auto& master : masters)
        for (Duration t = 1ms; t < length; t += master.cycle) {
            auto next = t;
            for (const auto& poll : master.polls) due.emplace(next += 7ms, poll);
        }
    for (const auto& [t, poll] : due)
        line.exchange(t, poll.first, "03 00 " + to_hex(std::array{poll.second}) + " 0002", "03 04 00010002",
                      3ms);
}

std::vector<std::vector<int>> units_of(const std::vector<HeardMaster>& masters) {
    std::vector<std::vector<int>> units;
    for (const auto& master : masters) {
        units.emplace_back();
        for (const auto& poll : master.polls) units.back().push_back(poll.unit);
        std::ranges::sort(units.back());
    }
    return units;
}

TEST(LineListener, DistinguishesTwoMastersByTheirSteps) {
    Line line;
    play(line, {{100ms, {{1, 0}, {2, 0}, {3, 0}}}, {130ms, {{4, 0}, {5, 0}}}}, 10s);
    const auto masters = line.listener.statistics().masters();
    ASSERT_EQ(units_of(masters), (std::vector<std::vector<int>>{{1, 2, 3}, {4, 5}}));
    EXPECT_EQ(masters[0].cycle.median, 100ms);
    EXPECT_EQ(masters[1].cycle.median, 130ms);
}

TEST(LineListener, OverlapsSeparateMastersThatKeepStep) {
    for (const int every : {1, 3}) {  // each cycle, or each third one
        Line line;
        for (int i = 0; i < 60; ++i) {
            const Duration t = i * 100ms;
            const bool overlaps = i > 0 && i % every == 0;
            line.send(t, 1, "03 0000 0001");
            if (overlaps) line.send(t + 2ms, 2, "03 0000 0001");
            line.send(t + 4ms, 1, "03 02 0001");
            if (!overlaps) line.send(t + 5ms, 2, "03 0000 0001");
            line.send(t + 8ms, 2, "03 02 0001");
        }
        EXPECT_EQ(line.listener.statistics().counts().overlaps, every == 1 ? 59U : 19U);
        EXPECT_EQ(line.listener.statistics().masters().size(), every == 1 ? 1U : 2U) << every;
    }
}

TEST(LineListener, OneMasterMayHaveSeveralPeriods) {
    Line line;
    std::vector<Master> one{{100ms, {{1, 0}}}, {500ms, {{1, 10}, {2, 0}}}};
    play(line, one, 20s);
    EXPECT_EQ(units_of(line.listener.statistics().masters()), (std::vector<std::vector<int>>{{1, 1, 2}}));
}

TEST(LineListener, MakesAProject) {
    Line line;
    play(line, {{100ms, {{1, 0}, {1, 2}}}, {500ms, {{1, 1}, {2, 0}}}}, 10s);
    line.exchange(11s, 1, "05 0011 FF00", "05 0011 FF00");
    line.exchange(11100ms, 1, "01 0010 0003", "01 01 00", 400ms);
    line.exchange(11600ms, 1, "04 0000 0001", "84 02");
    const auto project = heard_project(line.listener.statistics(), {.port = "/dev/ttyUSB0"});
    ASSERT_EQ(project.line.devices.size(), 2U);
    const auto& first = project.line.devices[0];
    EXPECT_EQ(first.name, "unit 1");
    EXPECT_EQ(first.poll_period, 100ms);
    EXPECT_EQ(first.response_timeout, 1200ms);
    std::string text;
    for (const auto& variable : first.variables)
        text += variable.name + "@" + std::to_string(variable.period / 1ms) + (variable.read ? "r" : "") +
                (variable.write ? "w " : " ");
    EXPECT_EQ(text,
              "unit1_coil_16@100r unit1_coil_17@100rw unit1_coil_18@100r unit1_holding_0@100r "
              "unit1_holding_1@100r unit1_holding_2@100r unit1_holding_3@100r ");
    using Ranges = std::vector<model::ItemRange>;
    EXPECT_EQ(first.readable[3], (Ranges{{0, 3}}));
    EXPECT_TRUE(first.readable[2].empty()) << "what it refuses is not read";
    EXPECT_EQ(project.line.devices[1].poll_period, 500ms);
}

TEST(LineListener, TheProjectHasWhatCombinedFunctionsWrite) {
    Line line;
    for (int i = 0; i < 3; ++i) {
        line.exchange(i * 1s, 1, "17 0003 0002 000E 0002 04 0001 0002", "17 04 0001 0002");
        line.exchange(i * 1s + 500ms, 1, "16 0014 00F2 0025", "16 0014 00F2 0025");
        line.exchange(i * 1s + 600ms, 2, "17 0003 0001 000E 0001 02 0001", "97 01");
    }
    const auto project = heard_project(line.listener.statistics(), {.port = "/dev/ttyUSB0"});
    const auto& device = project.line.devices[0];
    EXPECT_TRUE(device.fc22 && device.fc23);
    std::string text;
    for (const auto& variable : device.variables)
        text += variable.name + (variable.read ? "r" : "") +
                (variable.write ? std::to_string(static_cast<int>(*variable.write)) + " " : " ");
    EXPECT_EQ(text,
              "unit1_holding_3r unit1_holding_4r unit1_holding_14"
              "16 unit1_holding_15"
              "16 unit1_holding_20"
              "6 ");
    EXPECT_FALSE(project.line.devices[1].fc23) << "it was refused";
    EXPECT_TRUE(project.line.devices[1].variables.empty());
}

// A turnaround follows from enough responses only.
TEST(LineListener, TheProjectHasBroadcastsAndTurnarounds) {
    Line line;
    for (int i = 0; i < 100; ++i) line.exchange(i * 1s, 1, "03 0000 0001", "03 02 0001", 21ms);
    for (int i = 0; i < 99; ++i) line.exchange(100s + i * 1s, 2, "03 0000 0001", "03 02 0001", 21ms);
    line.send(200s, 0, "10 0005 0002 04 0001 0002");
    line.send(201s, 0, "06 0001 0003");
    const auto project = heard_project(line.listener.statistics(), {.port = "/dev/ttyUSB0"});
    ASSERT_EQ(project.line.devices.size(), 3U);
    const auto& all = project.line.devices[0];
    EXPECT_EQ(all.address, kBroadcast);
    std::string text;
    for (const auto& variable : all.variables)
        text += variable.name + (variable.read ? "r" : "") + (variable.write ? "w " : " ");
    EXPECT_EQ(text, "unit0_holding_1w unit0_holding_5w unit0_holding_6w ");
    EXPECT_FALSE(all.turnaround);
    const auto turnaround = project.line.devices[1].turnaround;
    ASSERT_TRUE(turnaround);
    EXPECT_GE(*turnaround, line.listener.statistics().devices().at(1).times.max() * 6 / 5);
    EXPECT_LE(*turnaround, 30ms);
    EXPECT_FALSE(project.line.devices[2].turnaround);
}

// Times of a capture may be anything.
TEST(LineListener, APeriodOfYearsIsADay) {
    constexpr Duration kYears = 24h * 365 * 20;
    Line line;
    for (int i = 0; i < 4; ++i) {
        line.exchange(i * 2 * kYears, 1, "03 0000 0001", "03 02 0001");
        line.exchange(i * 2 * kYears + kYears, 1, "03 0005 0001", "03 02 0001");
    }
    const auto project = heard_project(line.listener.statistics(), {}, 64);
    ASSERT_EQ(project.line.devices.size(), 1u);
    EXPECT_EQ(project.line.devices[0].poll_period, 24h);
}

TEST(HeardProject, RoundsPeriods) {
    EXPECT_EQ(nice_period(99600us), 100ms);
    EXPECT_EQ(nice_period(1012ms), 1s);
    EXPECT_EQ(nice_period(131ms), 130ms);
    EXPECT_EQ(nice_period(10400us), 10ms);
    EXPECT_EQ(nice_period(1us), 1ms);
    EXPECT_EQ(nice_period(48h), 24h);
}

TEST(LineListener, MemoryIsBounded) {
    Line line;
    for (int i = 0; i < 2000; ++i) {
        const std::array<std::uint8_t, 2> start{static_cast<std::uint8_t>(i >> 8),
                                                static_cast<std::uint8_t>(i)};
        line.exchange(i * 20ms, 1, "03 " + to_hex(start) + " 0001", "03 02 0001");
    }
    const auto& device = line.listener.statistics().devices().at(1);
    EXPECT_EQ(device.polls.size(), HeardDevice::kMostPolls);
    EXPECT_EQ(device.other_polls, 2000 - HeardDevice::kMostPolls);
    EXPECT_EQ(device.answered, 2000U);
}

}  // namespace line_listener_test
}  // namespace takt::capture
