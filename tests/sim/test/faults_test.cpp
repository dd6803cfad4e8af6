// The effect of each kind of fault on the real engines: a wrong value is never reported, and the line
// is well again afterwards.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>

#include "fault_plant.hpp"
#include "sim/faults/frames.hpp"
#include "sim/faults/line_faults.hpp"
#include "support.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::sim {
namespace faults_test {

using namespace std::chrono_literals;
using wire::Area;

/// Every register holds unit, address and, in its lowest bits, the second in which it was read.
struct Labels final : ValueSource {
    static std::uint16_t of(unsigned unit, unsigned address, Instant t) {
        const auto second = static_cast<unsigned>(t.time_since_epoch() / 1s);
        return static_cast<std::uint16_t>(unit << 12 | (address & 0x1F) << 7 | (second & 0x7F));
    }
    std::uint16_t item(UnitId unit, Area, std::uint16_t address, Instant t) const override {
        return of(unit.value, address, t);
    }
};

struct Events final : FaultObserver {
    void on_fault(const FaultEvent& event) override { all.push_back(event); }
    std::vector<FaultEvent> all;
};

/// Three devices, their master, the given faults for `faulty`, then `peace`.
struct Session {
    Session(Medium medium, FaultPlan faults, Duration faulty = 25s, std::size_t chunk = 0,
            Duration peace = 7s)
        : project(sim::project(medium)),
          plan(plan::make_plan(project)),
          master(project, plan),
          line(project.lines[0], master.line(0), options(std::move(faults), faulty, chunk)) {
        line.set_observer(&record);
        line.start(at(1s));
        until(1s + faulty);
        until(1s + faulty + peace);
    }
    SimulatedLine::Options options(FaultPlan faults, Duration faulty, std::size_t chunk) {
        if (faults.quiet_from == kNever) faults.quiet_from = at(1s + faulty);
        SimulatedLine::Options result;
        result.devices.source = &labels;
        result.devices.unknown_turnaround = 3ms;
        result.chunk = chunk;
        result.faults = faults_of(std::move(faults), &events);
        result.must_reconnect = [this] { return master.line(0).must_reconnect(); };
        return result;
    }
    void until(Duration since_start) {
        for (; now < at(since_start); now += 100ms) {
            line.advance(now);
            check();
        }
    }
    /// No variable shows what its own register did not hold when it was read.
    void check() {
        for (const auto& device : project.lines[0].devices)
            for (const auto& variable : device.variables) {
                const value::Slot& slot = master.store()[*master.store().find(variable.name)];
                if (!slot.good_at || slot.quality != value::Quality::good) continue;
                const auto shown = std::get<std::uint64_t>(slot.value);
                bool held = false;  // the answer may have been delayed, or have waited in a stopped computer
                for (Duration back{}; back <= 8s; back += 500ms)
                    held = held || shown == Labels::of(device.address.value, variable.register_number,
                                                       *slot.good_at - back);
                wrong_values += !held;
            }
    }
    bool all_good() {
        return std::ranges::all_of(project.lines[0].devices, [&](const model::Device& device) {
            return std::ranges::all_of(device.variables, [&](const model::Variable& variable) {
                const value::Slot& slot = master.store()[*master.store().find(variable.name)];
                return slot.quality == value::Quality::good && *slot.good_at > now - 400ms;
            });
        });
    }
    std::uint64_t injected(FaultKind kind) { return fault_counts(line).of(kind); }

    Labels labels;
    Events events;
    model::Project project;
    plan::Plan plan;
    poll::Master master;
    Record record;
    int wrong_values = 0;
    Instant now = at(1s);
    SimulatedLine line;
};

/// A copy can look like the true answer. takt-sim judges from the bytes whether a master could know.
bool can_be_recognised(FaultKind kind, Medium medium) {
    return medium == Medium::tcp ||
           (kind != FaultKind::duplicate_response && kind != FaultKind::past_response);
}

struct Case {
    FaultKind kind;
    Medium medium;
};

class EachKind : public testing::TestWithParam<Case> {};

// Where nothing is written no write goes wrong: writes have tests of their own below.
std::vector<Case> cases() {
    std::vector<Case> result;
    for (const Medium medium : kMedia)
        for (std::size_t k = 0; k < kFaultKinds; ++k) {
            const auto kind = static_cast<FaultKind>(k);
            const model::Line line = project(medium).lines[0];
            const bool begins = kind != FaultKind::device_back && kind != FaultKind::link_up;
            const bool of_writes = kind == FaultKind::wrong_echo || kind == FaultKind::ignored_write;
            if (possible(kind, line.framing, line.is_serial()) && begins && !of_writes)
                result.push_back({kind, medium});
        }
    return result;
}

TEST_P(EachKind, HappensShowsNoWrongValueAndPasses) {
    const auto [kind, medium] = GetParam();
    Session run(medium, only(kind));
    EXPECT_GE(run.injected(kind), 3u);
    EXPECT_GE(fault_counts(run.line).recovered_from(kind), 1u);
    if (can_be_recognised(kind, medium)) {
        EXPECT_EQ(run.wrong_values, 0);
    }
    EXPECT_TRUE(run.all_good());
    EXPECT_EQ(run.events.all.size(), fault_counts(run.line).total());
    for (const FaultEvent& event : run.events.all)
        EXPECT_LE(event.time, at(27s));  // late ones are reported when they arrive
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
    static constexpr std::array kNames{"rtu", "ascii", "rtu_over_tcp", "tcp"};
    return std::string(name(info.param.kind)) + "_" + kNames[static_cast<std::size_t>(info.param.medium)];
}
INSTANTIATE_TEST_SUITE_P(Faults, EachKind, testing::ValuesIn(cases()), case_name);

TEST(Faults, NoneWithoutRates) {
    for (const Medium medium : kMedia) {
        Session run(medium, {}, 5s);
        EXPECT_EQ(fault_counts(run.line).total(), 0u);
        EXPECT_GT(fault_counts(run.line).exchanges, 100u);
        EXPECT_TRUE(run.all_good());
    }
}

TEST(Faults, AllTogether) {
    for (const Medium medium : kMedia)
        for (const std::size_t chunk : {0u, 1u}) {
            if (chunk == 1 && medium != Medium::rtu && medium != Medium::ascii) continue;
            FaultPlan plan;
            plan.rates = FaultRates::all(8'000, 15s);
            for (const auto kind : {FaultKind::duplicate_response, FaultKind::past_response})
                if (!can_be_recognised(kind, medium)) plan.rates.set(kind, 0);
            plan.turnarounds.assign(3, Turnaround{Turnaround::Shape::long_tail, 1ms, 150ms});
            // Missing responses are expected for twice the usual lateness of their device, at most 30 s.
            // After that the values are in doubt for eight time-outs.
            Session run(medium, plan, 60s, chunk, 41s);
            EXPECT_EQ(run.wrong_values, 0) << static_cast<int>(medium);
            EXPECT_TRUE(run.all_good()) << static_cast<int>(medium);
        }
}

TEST(Faults, TheSameSeedGivesTheSameBytes) {
    for (const Medium medium : kMedia) {
        const auto bytes = [&](std::uint64_t seed) {
            FaultPlan plan;
            plan.seed = seed;
            plan.rates = FaultRates::all(10'000, 10s);
            return Session(medium, plan, 20s).record.entries;
        };
        const auto first = bytes(7);
        EXPECT_EQ(first, bytes(7));
        EXPECT_NE(first, bytes(8));
    }
}

TEST(Faults, EveryKindHasItsOwnName) {
    std::map<std::string_view, int> names;
    for (std::size_t k = 0; k < kFaultKinds; ++k) ++names[name(static_cast<FaultKind>(k))];
    EXPECT_EQ(names.size(), kFaultKinds);
    EXPECT_EQ(name(FaultKind::connect_refused), "connect_refused");
    EXPECT_EQ(name(FaultKind::device_dead), "device_dead");
}

/// The outcomes of commands, one a second, while half of the writes meet a fault.
struct FaultyWrites {
    std::map<value::CommandResult, int> results;
    int faults = 0;
};

FaultyWrites faulty_writes(model::Project described, FaultKind kind, std::uint64_t commands) {
    const plan::Plan plan = plan::make_plan(described);
    poll::Master master(described, plan);
    SimulatedLine::Options options;
    FaultPlan faults;
    faults.rates.set(kind, 500'000);
    options.faults = faults_of(std::move(faults));
    options.must_reconnect = [&] { return master.line(0).must_reconnect(); };
    SimulatedLine line(described.lines[0], master.line(0), options);
    line.start(at(0s));
    line.advance(at(1s));
    FaultyWrites writes;
    for (std::uint64_t i = 0; i < commands; ++i) {
        const value::WriteCommand command{i, *master.store().find("d1.v0"), std::uint64_t{i + 1}, kNever};
        EXPECT_TRUE(master.write(at(1s) + 1s * i, command));
        line.advance(at(2s) + 1s * i);
        while (const auto outcome = master.take_outcome()) ++writes.results[outcome->result];
    }
    writes.faults = static_cast<int>(fault_counts(line).of(kind));
    return writes;
}

// A write is not reported as done if the device answered something else.
TEST(Faults, AWriteWithAWrongEchoIsUnknown) {
    for (const Medium medium : kMedia) {
        auto [results, faults] = faulty_writes(project(medium), FaultKind::wrong_echo, 40);
        EXPECT_EQ(results[value::CommandResult::unknown], faults);
        EXPECT_EQ(results[value::CommandResult::done], 40 - faults);
        EXPECT_GE(faults, 10);
    }
}

// The device answers that it is done; only a read back shows that it is not.
TEST(Faults, AnIgnoredWriteIsSeenByVerifyAlone) {
    for (const Medium medium : kMedia)
        for (const bool verify : {false, true}) {
            model::Project described = project(medium);
            described.lines[0].devices[0].variables[0].verify = verify;
            auto [results, faults] = faulty_writes(std::move(described), FaultKind::ignored_write, 40);
            EXPECT_GE(faults, 10);
            EXPECT_EQ(results[value::CommandResult::refused], verify ? faults : 0);
        }
}

// A server may send the answers to several requests in one segment. Each of them is an answer of its own: no
// later answer is taken for one that is overdue.
TEST(Faults, AnswersInOneSegmentAreCountedOneByOne) {
    for (const Medium medium : {Medium::rtu_over_tcp, Medium::tcp}) {
        const model::Project described = project(medium);
        const auto framing = described.lines[0].framing;
        const auto request = [&](std::uint8_t unit, std::uint16_t transaction) {
            return close_frame(framing, {unit, transaction, {0x03, 0x00, 0x00, 0x00, 0x01}});
        };
        Talker client;
        ByteVector both = request(1, 1);
        for (const auto byte : request(2, 2)) both.push_back(byte);
        client.send(at(1s), both);
        client.send(at(5s), request(1, 3));
        SimulatedLine::Options options;
        FaultPlan faults;
        faults.turnarounds = {Turnaround{Turnaround::Shape::constant, 10ms, 10ms},
                              Turnaround{Turnaround::Shape::constant, 0ms, 0ms}};
        options.faults = faults_of(std::move(faults));
        SimulatedLine line(described.lines[0], client, options);
        line.start(at(0s));
        line.advance(at(10s));
        EXPECT_EQ(line.counters().answers, 3U);
        ASSERT_FALSE(client.received.empty());
        EXPECT_GE(client.received.back().first, at(5s + 10ms));
        EXPECT_EQ(fault_counts(line).of(FaultKind::late_response), 0U);
    }
}

}  // namespace faults_test
}  // namespace takt::sim
