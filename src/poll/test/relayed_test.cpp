// Transactions of others on a polled line: their order in the queue, and the bounds of polling.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "bench.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::poll {
namespace relayed_test {

using namespace test;

constexpr std::uint8_t kForeign = 77;  // a unit that is no device of the project

model::Project shared(std::vector<model::Device> devices, Duration interval = 1s) {
    auto made = project(std::move(devices), {local("go")});
    made.lines[0].relayed = model::SharedLine{20ms};
    made.lines[0].relay_interval = interval;
    return made;
}

bus::Transaction transaction(bus::TransactionId id, const wire::Request& request,
                             std::uint8_t unit = kForeign) {
    return {.id = id, .unit = UnitId{unit}, .request = wire::prepare(request).value(), .wait = 20ms};
}
bus::Transaction read(bus::TransactionId id, std::uint8_t unit = kForeign, std::uint16_t start = 500) {
    return transaction(id, wire::ReadRequest{Function::read_holding_registers, DataAddress{start}, 2}, unit);
}

/// Devices that are asked all the time: each registers of its own, each 20 ms.
std::vector<model::Device> busy_devices(int count) {
    std::vector<model::Device> devices;
    for (int d = 1; d <= count; ++d) {
        devices.push_back(device(d, {int16("v" + std::to_string(d), 0).read(3).every(20ms)}));
        devices.back().turnaround = 3ms;
    }
    return devices;
}

std::size_t foreign(const std::vector<Sent>& sent) {
    return static_cast<std::size_t>(std::ranges::count(sent, kForeign, &Sent::unit));
}

/// A client that always has a further request.
void flood(Bench& bench) {
    bench.players[kForeign];
    bench.after_each = [&bench] {
        if (bench.master.line(0).can_relay()) {
            const auto taken = bench.master.line(0).relay(bench.now, read(bench.relayed.size() + 1));
            EXPECT_TRUE(taken);
        }
    };
    bench.after_each();
}

TEST(Relayed, AreAnsweredUnderTheirOwnNumber) {
    Bench bench(shared(busy_devices(1)));
    bench.players[kForeign].registers = {{500, 7}, {501, 8}};
    ASSERT_TRUE(bench.master.line(0).can_relay());
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(41)));
    EXPECT_FALSE(bench.master.line(0).can_relay());
    EXPECT_EQ(bench.master.line(0).relay(bench.now, read(42)).error().code, Code::queue_full);
    bench.run_until(100ms);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].id, 41u);
    EXPECT_EQ(bench.relayed[0].unit, UnitId{kForeign});
    EXPECT_EQ(hex(bench.relayed[0].response.pdu()), "03 04 00 07 00 08");
    EXPECT_TRUE(bench.master.line(0).can_relay());
}

TEST(Relayed, IsTakenBackUnlessItWasSent) {
    Bench bench(shared(busy_devices(1)));
    auto& line = bench.master.line(0);
    EXPECT_FALSE(line.withdraw_relayed());
    bench.run_until(100ms);
    ASSERT_TRUE(line.relay(bench.now, read(1)));
    EXPECT_TRUE(line.withdraw_relayed());
    EXPECT_FALSE(line.withdraw_relayed());
    ASSERT_TRUE(line.can_relay());
    bench.run_until(300ms);
    EXPECT_TRUE(bench.relayed.empty()) << "it has no outcome";
    EXPECT_EQ(foreign(bench.sent), 0u);
    ASSERT_TRUE(line.relay(bench.now, read(2)));
    bench.after_each = [&] {
        if (foreign(bench.sent) == 0 || !bench.relayed.empty()) return;
        EXPECT_FALSE(line.withdraw_relayed());
    };
    bench.run_until(600ms);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].id, 2u);
}

TEST(Relayed, ALineThatIsNotSharedTakesNone) {
    Bench bench(project(busy_devices(1)));
    EXPECT_FALSE(bench.master.line(0).can_relay());
    EXPECT_EQ(bench.master.line(0).relay(bench.now, read(1)).error().code, Code::unsupported);
}

TEST(Relayed, AGuestIsSentOnlyWhenNothingIsDue) {
    Bench bench(project(busy_devices(1)));
    auto& line = bench.master.line(0);
    EXPECT_EQ(line.relay(bench.now, read(1)).error().code, Code::unsupported);
    line.admit_guests();
    line.admit_guests();
    bench.players[kForeign].registers = {{500, 7}, {501, 8}};
    flood(bench);
    bench.run_until(1s);
    EXPECT_GT(bench.relayed.size(), 20u);
    const auto polls = static_cast<std::size_t>(std::ranges::count(bench.sent, 1, &Sent::unit));
    EXPECT_GE(polls, 45u) << "each 20 ms";
}

/// The instants at which devices of periods are polled beside a client that always has a further request.
struct Polled {
    std::vector<Instant> polls;
    std::size_t guests = 0;
};
Polled polled_beside(bool guests, bool spare, bool answers, Duration end) {
    std::vector<model::Device> devices;
    for (const Duration period : {50ms, 70ms, 130ms}) {
        const auto number = static_cast<int>(devices.size()) + 1;
        devices.push_back(device(number, {int16("v" + std::to_string(number), 0).read(3).every(period)}));
        devices.back().turnaround = 3ms;
    }
    Bench bench(project(devices));
    auto& line = bench.master.line(0);
    line.admit_guests();
    bench.players[kForeign].dead = !answers;
    if (guests)
        bench.after_each = [&] {
            if (line.can_relay()) static_cast<void>(line.relay(bench.now, read(1), spare));
        };
    bench.run_until(end);
    Polled found{.guests = foreign(bench.sent)};
    for (const auto& sent : bench.sent)
        if (sent.unit != kForeign) found.polls.push_back(sent.t);
    return found;
}

TEST(Relayed, AGuestInSpareTimeMakesNoPolledRequestLate) {
    const auto alone = polled_beside(false, false, true, 10s);
    for (const bool answers : {true, false}) {
        const auto beside = polled_beside(true, true, answers, 10s);
        EXPECT_GT(beside.guests, 100u);
        EXPECT_EQ(beside.polls, alone.polls) << "at the same instants as without it";
    }
    EXPECT_NE(polled_beside(true, false, false, 10s).polls, alone.polls) << "one at any time delays polling";
}

TEST(Relayed, AGuestInSpareTimeWaitsWhileTheLineHasNone) {
    Bench bench(project(busy_devices(1)));  // each 20 ms: less than the guest's time-out
    auto& line = bench.master.line(0);
    line.admit_guests();
    ASSERT_TRUE(line.relay(bench.now, read(1), true));
    bench.run_until(2s);
    EXPECT_EQ(foreign(bench.sent), 0u);
    EXPECT_TRUE(line.withdraw_relayed());
}

// It must not keep the slot from a gateway.
TEST(Relayed, OnASharedLineAGuestInSpareTimeIsOneOfTheRelayed) {
    Bench bench(shared(busy_devices(6), 50ms));  // more than the line can hold
    auto& line = bench.master.line(0);
    bench.players[kForeign].dead = true;
    auto asked = read(1);
    asked.wait = 5s;
    ASSERT_TRUE(line.relay(bench.now, asked, true));
    bench.run_until(500ms);
    ASSERT_EQ(bench.relayed.size(), 1u) << "with the time-out of the gateway";
}

TEST(Relayed, AGuestWaitsForALineThatIsNeverFree) {
    auto devices = busy_devices(8);
    for (auto& device : devices)
        for (auto& variable : device.variables) variable.period = 1ms;
    Bench bench(project(devices));
    bench.master.line(0).admit_guests();
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1)));
    bench.run_until(2s);
    EXPECT_EQ(foreign(bench.sent), 0u);
    EXPECT_TRUE(bench.master.line(0).withdraw_relayed());
}

TEST(Relayed, ALineWithoutDevicesOnlyRelays) {
    auto described = shared({});
    Bench bench(described);
    flood(bench);
    bench.run_until(1s);
    EXPECT_GT(bench.relayed.size(), 100u);
    EXPECT_TRUE(
        std::ranges::all_of(bench.relayed, [](const auto& o) { return o.status == bus::Status::ok; }));
}

TEST(Relayed, GoAheadOfPollingOnceAnIntervalAndElseWhenNothingIsDue) {
    for (const Duration interval : {50ms, 200ms}) {
        Bench bench(shared(busy_devices(6), interval));  // more than the line can hold
        ASSERT_GT(bench.plan.lines[0].utilization, 1);
        flood(bench);
        bench.run_until(2s);
        const auto count = static_cast<std::int64_t>(foreign(bench.sent));
        EXPECT_GE(count, 2s / (interval + 10ms)) << "a transaction may be under way when its turn comes";
        EXPECT_LE(count, 2s / interval + 1);
    }
}

// The distance counts from the end of the last one: however long they take, the line is left to polling for
// an interval after each.
TEST(Relayed, PollingGoesBetweenTwoThatTakeLongerThanTheInterval) {
    for (const bool answers : {true, false}) {
        Bench bench(shared(busy_devices(2), 20ms));
        flood(bench);
        bench.players[kForeign].turnaround = 19ms;
        bench.players[kForeign].dead = !answers;
        bench.run_until(10s);
        ASSERT_GT(foreign(bench.sent), 100u);
        std::array<std::size_t, 2> polled{};
        for (std::size_t i = 1; i < bench.sent.size(); ++i) {
            EXPECT_FALSE(bench.sent[i].unit == kForeign && bench.sent[i - 1].unit == kForeign)
                << "at " << bench.sent[i].t.time_since_epoch().count();
            if (bench.sent[i].unit != kForeign) ++polled.at(bench.sent[i].unit - 1);
        }
        EXPECT_GT(polled[0], 200u);
        EXPECT_GT(polled[1], 200u);
        EXPECT_EQ(bench.slot("v1").quality, value::Quality::good);
    }
}

// Another project is applied.
TEST(Relayed, OneInFlightIsAwaitedBeforeAnotherPollerTakesOver) {
    Bench bench(shared(busy_devices(0)));
    bench.players[kForeign].turnaround = 10ms;
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1)));
    bench.run_until(5ms);
    ASSERT_EQ(foreign(bench.sent), 1u);
    bench.master.line(0).hold();
    EXPECT_FALSE(bench.master.line(0).idle());
    bench.run_until(500ms);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].status, bus::Status::ok);
    EXPECT_TRUE(bench.master.line(0).idle());
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1)));
    bench.run_until(1s);
    EXPECT_EQ(foreign(bench.sent), 1u) << "a held line relays no more";
    EXPECT_TRUE(bench.master.line(0).withdraw_relayed());
}

TEST(Relayed, ADeviceThatPollingKnowsAsDeadIsNotAsked) {
    Bench bench(shared(busy_devices(2)));
    bench.players[2].dead = true;
    bench.run_until(3s);
    ASSERT_EQ(bench.master.line(0).device(1).state, DeviceState::not_answering);
    bench.news();
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1, 2, 700)));
    bench.run_until(bench.now.time_since_epoch() + 500ms);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].status, bus::Status::timeout);
    EXPECT_FALSE(bench.relayed[0].sent);
    EXPECT_EQ(std::ranges::count(bench.news(), 700, &Sent::start), 0);
    bench.players[2].dead = false;
    bench.run_until(10s);
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(2, 2, 700)));
    bench.run_until(11s);
    ASSERT_EQ(bench.relayed.size(), 2u);
    EXPECT_EQ(bench.relayed[1].status, bus::Status::ok);
}

TEST(Relayed, TakeWhatPollingLeaves) {
    Bench bench(shared(busy_devices(1)));
    flood(bench);
    bench.run_until(2s);
    EXPECT_GT(foreign(bench.sent), 100u);
    EXPECT_GE(std::ranges::count(bench.sent, 1, &Sent::unit), 99);
}

TEST(Relayed, ComeAfterWhatIsCommanded) {
    auto devices = busy_devices(1);
    devices[0].variables.push_back(int16("w", 9).read(3).write(6).every(1s));
    Bench bench(shared(devices));
    bench.players[kForeign];
    bench.run_until(5ms);
    bench.news();
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1)));
    ASSERT_TRUE(bench.write(1, "w", std::int64_t{5}));
    bench.run_until(60ms);
    const auto news = bench.news();
    const auto written = std::ranges::find(news, 6, &Sent::function);
    const auto relayed = std::ranges::find(news, kForeign, &Sent::unit);
    ASSERT_TRUE(written != news.end() && relayed != news.end());
    EXPECT_LT(written->t, relayed->t);
}

TEST(Relayed, ADeadUnitIsReportedAndPollingGoesOn) {
    Bench bench(shared(busy_devices(1)));
    bench.players[kForeign].dead = true;
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1)));
    bench.run_until(1s);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].status, bus::Status::timeout);
    EXPECT_EQ(bench.slot("v1").quality, value::Quality::good);
    EXPECT_EQ(foreign(bench.sent), 1u) << "sent once";
}

TEST(Relayed, WhatWasNotSentWhenTheLinkWentAwaySaysSo) {
    Bench bench(shared(busy_devices(1)));
    bench.run_until(1ms);  // a poll is in flight
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1)));
    bench.link(false);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].status, bus::Status::link_lost);
    EXPECT_FALSE(bench.relayed[0].sent);
    EXPECT_FALSE(bench.master.line(0).can_relay());
    EXPECT_EQ(bench.master.line(0).relay(bench.now, read(1)).error().code, Code::connection_lost);
    bench.link(true);
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(2)));
    bench.link(false);
    bench.link(true);
    bench.run_until(200ms);
    ASSERT_EQ(bench.relayed.size(), 2u);
    EXPECT_EQ(foreign(bench.sent), 0u);
}

TEST(Relayed, ALateAnswerToOneIsNotTakenForPolling) {
    auto devices = busy_devices(0);
    devices.push_back(device(5, {int16("v", 500).read(3).every(20ms), int16("x", 501).read(3).every(20ms)}));
    devices[0].turnaround = 3ms;
    Bench bench(shared(devices));
    bench.players[5].registers = {{500, 1}, {501, 1}, {600, 99}, {601, 99}};
    bench.run_until(90ms);               // between two polls
    bench.players[5].turnaround = 30ms;  // later than its deadline
    ASSERT_TRUE(bench.master.line(0).relay(bench.now, read(1, 5, 600)));
    bench.run_until(95ms);
    bench.players[5].turnaround = 3ms;
    bench.run_until(1s);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].status, bus::Status::timeout);
    EXPECT_EQ(std::get<std::int64_t>(bench.slot("v").value), 1);
}

TEST(Relayed, AConnectionThatSaysNothingIsMadeAnew) {
    auto described = shared({});
    described.lines[0].transport = model::Transport::tcp;
    described.lines[0].format.baud = 0;
    Bench bench(described);
    flood(bench);
    bench.players[kForeign].dead = true;
    bench.run_until(29s);
    EXPECT_FALSE(bench.master.line(0).must_reconnect());
    bench.run_until(31s);
    EXPECT_TRUE(bench.master.line(0).must_reconnect());
}

// Without an interval every request of the client may go first.
TEST(Relayed, PollingThatIsOverdueGoesBetweenTwo) {
    for (const auto order : {model::PollOrder::deadline, model::PollOrder::address}) {
        auto described = shared(busy_devices(2), Duration::zero());
        described.lines[0].order = order;
        Bench bench(described);
        flood(bench);
        bench.players[kForeign].turnaround = 15ms;
        bench.run_until(10s);
        EXPECT_GT(foreign(bench.sent), 100u);
        for (const int unit : {1, 2})
            EXPECT_GT(std::ranges::count(bench.sent, unit, &Sent::unit), 90) << unit;
    }
}

// Each request that is not answered holds back polling of the same form, until its response cannot come any
// more.
TEST(Relayed, SilenceOfADeviceDoesNotKeepItFromBeingPolled) {
    auto devices = busy_devices(0);
    devices.push_back(device(1, {int16("v", 0).read(4).every(2s)}));
    devices[0].turnaround = 20ms;
    devices[0].response_timeout = 1s;
    Bench bench(shared(devices, 40ms));
    bench.players[1].silent_about = {1000};
    bench.after_each = [&bench] {
        if (!bench.master.line(0).can_relay()) return;
        const auto id = bench.relayed.size() + 1;
        const bool silent = id % 2 == 1;
        const wire::ReadRequest request{
            silent ? Function::read_input_registers : Function::read_holding_registers,
            DataAddress{static_cast<std::uint16_t>(silent ? 1000 : 0)}, 1};
        EXPECT_TRUE(bench.master.line(0).relay(bench.now, transaction(id, request, 1)));
    };
    bench.after_each();
    bench.run_until(60s);
    const auto polls = std::ranges::count_if(
        bench.sent, [](const Sent& sent) { return sent.function == 4 && sent.start == 0; });
    EXPECT_GE(polls, 29);
    EXPECT_GT(bench.relayed.size(), 60u) << "clients go on";
}

TEST(Relayed, ABroadcastGoesThrough) {
    Bench bench(shared(busy_devices(1)));
    bench.players[0].dead = true;
    ASSERT_TRUE(bench.master.line(0).relay(
        bench.now, transaction(3, wire::WriteSingleRegisterRequest{DataAddress{4}, 5}, 0)));
    bench.run_until(500ms);
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].status, bus::Status::ok);
    EXPECT_TRUE(bench.relayed[0].response.empty());
}

TEST(Relayed, NoWriteGoesBetweenAWriteAndItsReadingBack) {
    auto devices = busy_devices(1);
    devices[0].variables.push_back(int16("w", 9).read(3).write(6).every(1s).verified());
    Bench bench(shared(devices));
    bench.run_until(50ms);
    ASSERT_TRUE(bench.write(1, "w", std::int64_t{5}));
    bench.after_each = [&bench, done = false]() mutable {
        if (done || bench.sent.empty() || bench.sent.back().function != 6) return;
        done = true;
        const wire::WriteSingleRegisterRequest write{DataAddress{9}, 6};
        EXPECT_TRUE(bench.master.line(0).relay(bench.now, transaction(1, write, 1)));
    };
    bench.run_until(1s);
    EXPECT_TRUE(bench.observed.differing.empty());
    ASSERT_EQ(bench.relayed.size(), 1u);
    EXPECT_EQ(bench.relayed[0].status, bus::Status::ok);
    EXPECT_EQ(bench.players[1].registers[9], 6);
}

// The longest transactions there are, as often as they are accepted: the bounds of polling hold.
TEST(Relayed, PollingKeepsItsGuarantee) {
    std::mt19937 random(11);
    int feasible = 0;
    for (int round = 0; round < 60; ++round) {
        std::vector<model::Device> devices;
        for (int d = 1; d <= 1 + static_cast<int>(random() % 3); ++d) {
            constexpr Duration kPeriods[] = {200ms, 240ms, 400ms, 1000ms};
            devices.push_back(
                device(d, {int16("v" + std::to_string(d), 0).read(3).every(kPeriods[random() % 4]),
                           int16("u" + std::to_string(d), 50).read(3).every(kPeriods[random() % 4])}));
            devices.back().turnaround = 4ms;
        }
        auto described = shared(devices, random() % 2 == 0 ? Duration(200ms) : Duration(1s));
        if (random() % 3 == 0) described.lines[0].order = model::PollOrder::address;
        const auto proved = plan::guarantee(described, plan::make_plan(described)).at(0);
        if (!proved.feasible) continue;
        ++feasible;
        Bench bench(described);
        for (auto& [unit, player] : bench.players) player.turnaround = 4ms;
        auto& player = bench.players[kForeign];
        player.turnaround = 20ms;
        player.silent_to = [&random](const wire::Request&) { return random() % 4 == 0; };
        bench.after_each = [&bench, &random] {
            if (!bench.master.line(0).can_relay() || random() % 3 == 0) return;
            const wire::ReadRequest longest{Function::read_holding_registers, DataAddress{0}, 125};
            EXPECT_TRUE(bench.master.line(0).relay(bench.now, transaction(1, longest)));
        };
        bench.run_until(3s);
        ASSERT_GT(foreign(bench.sent), 5u);
        std::vector<std::int64_t> count(proved.requests.size(), 0);
        const auto& requests = bench.plan.lines[0].requests;
        for (const auto& sent : bench.sent) {
            if (sent.unit == kForeign) continue;
            for (std::size_t r = 0; r < requests.size(); ++r) {
                if (devices[requests[r].device].address.value != sent.unit || requests[r].start != sent.start)
                    continue;
                const auto& bound = proved.requests[r];
                const Instant due = at(requests[r].phase + *requests[r].period * count[r]++);
                const Duration silence = wire::t3_5(described.lines[0].format);
                const Instant answered = sent.t + bound.transaction - silence - described.host.overhead;
                EXPECT_LE(answered, due + *bound.response) << "round " << round;
            }
        }
    }
    EXPECT_GT(feasible, 20);
}

// The longest writes there are, as often as they are taken, verified or not.
TEST(ClientsOfAServer, PollingKeepsItsGuaranteeBesideTheirCommands) {
    std::mt19937 random(12);
    int feasible = 0;
    for (int round = 0; round < 60; ++round) {
        std::vector<model::Device> devices;
        for (int d = 1; d <= 1 + static_cast<int>(random() % 3); ++d) {
            constexpr Duration kPeriods[] = {60ms, 100ms, 240ms, 1000ms};
            const auto name = std::to_string(d);
            auto written = int16("w" + name, 90).read(3).write(random() % 2 == 0 ? 6 : 16).every(1s);
            if (random() % 2 == 0) written = written.verified();
            if (random() % 3 == 0) written = written.on_change();
            written.written_by_clients = true;
            devices.push_back(
                device(d, {int16("v" + name, 0).read(3).every(kPeriods[random() % 4]),
                           int16("u" + name, 50).read(3).every(kPeriods[random() % 4]), written}));
            devices.back().turnaround = 4ms;
        }
        auto described = project(devices);
        described.lines[0].commands = {.min_interval = random() % 2 == 0 ? Duration(20ms) : Duration(100ms),
                                       .burst = static_cast<std::uint16_t>(1 + random() % 3)};
        if (random() % 3 == 0) described.lines[0].order = model::PollOrder::address;
        const auto proved = plan::guarantee(described, plan::make_plan(described)).at(0);
        if (!proved.feasible) continue;
        ++feasible;
        Bench bench(described);
        for (auto& [unit, player] : bench.players) player.turnaround = 4ms;
        bench.after_each = [&, sent = std::uint64_t{0}]() mutable {
            while (sent < bench.outcomes.size() + 4 && random() % 3 != 0) {
                const auto name = "w" + std::to_string(1 + random() % devices.size());
                ++sent;
                EXPECT_TRUE(bench.write(sent, name, std::int64_t(sent % 30'000)));
            }
        };
        bench.run_until(3s);
        ASSERT_GT(bench.outcomes.size(), 10u);
        std::vector<std::int64_t> count(proved.requests.size(), 0);
        const auto& requests = bench.plan.lines[0].requests;
        for (const auto& sent : bench.sent) {
            for (std::size_t r = 0; r < requests.size(); ++r) {
                if (sent.function != 3 || sent.start >= 90 || !requests[r].period ||
                    devices[requests[r].device].address.value != sent.unit || requests[r].start != sent.start)
                    continue;
                const auto& bound = proved.requests[r];
                const Instant due = at(requests[r].phase + *requests[r].period * count[r]++);
                const Duration silence = wire::t3_5(described.lines[0].format);
                const Instant answered = sent.t + bound.transaction - silence - described.host.overhead;
                EXPECT_LE(answered, due + *bound.response) << "round " << round;
            }
        }
    }
    EXPECT_GT(feasible, 20);
}

}  // namespace relayed_test
}  // namespace takt::poll
