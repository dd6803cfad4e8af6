// The real poller against simulated devices: the whole way of the data without a wire.
#include <gtest/gtest.h>

#include <map>

#include "support.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::sim {
namespace poller_test {

using namespace std::chrono_literals;
using wire::Area;
using wire::Function;

model::Variable variable(std::string name, DataType type, std::uint16_t number, Duration period) {
    model::Variable result;
    result.name = std::move(name);
    result.type = type;
    result.register_number = number;
    result.registers = static_cast<std::uint16_t>(register_count(type));
    result.read = Function::read_holding_registers;
    result.period = period;
    return result;
}

model::Device device(std::string name, std::uint8_t address, Duration period) {
    model::Device result;
    result.name = name;
    result.address = UnitId{address};
    result.poll_period = period;
    result.turnaround = 5ms;
    result.strategy = model::Strategy::classic;
    result.group_requests = true;
    result.registers_per_request = 125;
    for (std::uint16_t i = 0; i < 3; ++i) {
        result.variables.push_back(
            variable(name + ".f" + std::to_string(i), DataType::float32, 2 * i, period));
        result.variables.push_back(variable(name + ".i" + std::to_string(i), DataType::int16,
                                            static_cast<std::uint16_t>(100 + i), period));
    }
    return result;
}

struct LineKind {
    wire::Framing framing;
    wire::CharacterFormat format;
};
constexpr LineKind kRtu9600{wire::Framing::rtu, {9600, 8, wire::Parity::even, 1}};
constexpr LineKind kRtu115200{wire::Framing::rtu, {115200, 8, wire::Parity::none, 1}};
constexpr LineKind kAscii{wire::Framing::ascii, {19200, 7, wire::Parity::even, 1}};
constexpr LineKind kTcp{wire::Framing::tcp, {}};

model::Project project(const LineKind& kind, Duration period, std::uint8_t devices = 3) {
    model::Line line;
    line.name = "line";
    line.transport = model::Transport::simulated;
    line.framing = kind.framing;
    line.format = kind.format;
    line.order = model::PollOrder::address;
    for (std::uint8_t i = 1; i <= devices; ++i)
        line.devices.push_back(device("d" + std::to_string(i), i, period));
    model::Project result;
    result.lines.push_back(line);
    return result;
}

/// A project's first line with its master, its devices and the measured view.
struct Session {
    explicit Session(model::Project description, SimulatedLine::Options options = {})
        : project(std::move(description)),
          plan(plan::make_plan(project)),
          master(project, plan),
          line(project.lines[0], master.line(0), options) {
        line.set_observer(&record);
        line.start(Instant{});
    }
    const value::Slot& slot(std::string_view name) { return master.store()[*master.store().find(name)]; }
    Duration age(std::string_view name) { return now - slot(name).good_at.value(); }
    void until(Duration since_start) {
        now = at(since_start);
        line.advance(now);
    }

    model::Project project;
    plan::Plan plan;
    poll::Master master;
    SimulatedLine line;
    Record record;
    Instant now{};
};

Duration least_silence(const LineKind& kind) {
    return wire::t3_5(kind.format);
}

TEST(Simulation, ValuesArriveAndKeepTheirPeriod) {
    for (const LineKind& kind : {kRtu9600, kRtu115200, kAscii, kTcp}) {
        Session run(project(kind, 1s));
        run.until(10s);
        for (const char* name : {"d1.f0", "d2.f2", "d3.i1"}) {
            EXPECT_EQ(run.slot(name).quality, value::Quality::good) << name;
            EXPECT_LE(run.age(name), 1s + 200ms) << name;
        }
        EXPECT_EQ(run.line.counters().exceptions, 0u);
        EXPECT_EQ(run.line.counters().requests, run.line.counters().answers);
    }
}

TEST(Simulation, AValueIsWhatTheDeviceHeldWhenItWasAsked) {
    Session run(project(kRtu115200, 100ms));
    const Pattern pattern(DataType::float32, "d2.f1");
    run.until(20s);
    ASSERT_GE(run.record.entries.size(), 2u);
    std::optional<Instant> asked;  // the end of the last request to device 2 for its floats
    for (const auto& entry : run.record.entries)
        if (entry.sender == 0 && entry.bytes[0] == 2 && entry.bytes[3] == 0) asked = entry.end;
    ASSERT_TRUE(asked.has_value());
    EXPECT_TRUE(value::same(run.slot("d2.f1").value, pattern.at(*asked)));
}

// docs/planning.md, "Bus time": with the turnaround of the project a round takes exactly the planned time.
TEST(Simulation, TheCycleIsThePlansBusTime) {
    for (const LineKind& kind : {kRtu9600, kRtu115200, kAscii, kTcp}) {
        Session run(project(kind, 0ms));
        run.until(5s);
        const plan::LinePlan& plan = run.plan.lines[0];
        std::vector<Instant> rounds;
        for (const auto& entry : run.record.entries)
            if (entry.sender == 0 && entry.bytes == run.record.entries[0].bytes)
                rounds.push_back(entry.start);
        if (kind.framing == wire::Framing::tcp) {
            rounds.clear();
            for (std::size_t i = 0; i < run.record.entries.size(); i += 2 * plan.requests.size())
                rounds.push_back(run.record.entries[i].start);
        }
        ASSERT_GE(rounds.size(), 10u);
        for (std::size_t i = 1; i < rounds.size(); ++i) {
            const Duration measured = rounds[i] - rounds[i - 1];
            // Each of a transaction's parts is rounded up to a nanosecond by itself, the plan's only as a
            // whole.
            const auto rounding = Duration(4 * plan.requests.size());
            EXPECT_GE(measured, plan.cycle - rounding) << wire::name(kind.framing);
            EXPECT_LE(measured, plan.cycle + rounding) << wire::name(kind.framing);
        }
    }
}

TEST(Simulation, SilencesAsTheOtherEndSeesThemAreNeverTooShort) {
    for (const LineKind& kind : {kRtu9600, kRtu115200})
        for (const std::size_t chunk : {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{14}}) {
            Session run(project(kind, 0ms), {.chunk = chunk});
            run.line.devices()[0].behaviour.turnaround = {};
            run.line.devices()[1].behaviour.dead = true;
            run.until(20s);
            ASSERT_GT(run.record.entries.size(), 100u);
            EXPECT_GE(run.record.least_silence(), least_silence(kind)) << chunk;
            EXPECT_LE(run.record.least_silence(), least_silence(kind) + 1us) << chunk;
            for (const auto& entry : run.record.entries) EXPECT_FALSE(entry.collided);
        }
}

TEST(Simulation, ADeadDeviceDoesNotAgeTheOthers) {
    Session run(project(kRtu115200, 200ms));
    run.until(5s);
    run.line.devices()[1].behaviour.dead = true;
    run.until(15s);
    EXPECT_EQ(run.slot("d2.f0").quality, value::Quality::bad);
    EXPECT_EQ(run.master.line(0).device(1).state, poll::DeviceState::not_answering);
    const auto& answered = run.master.line(0).device(2).counters.answered;
    EXPECT_GE(answered, 2u * 15 * 5 - 10) << "two requests, each every 200 ms";
    EXPECT_EQ(run.slot("d1.f0").quality, value::Quality::good);
    EXPECT_LE(run.age("d3.f0"), 300ms);
    run.line.devices()[1].behaviour.dead = false;
    run.until(90s);
    EXPECT_EQ(run.slot("d2.f0").quality, value::Quality::good) << "it is probed, and comes back";
}

TEST(Simulation, ASlowDeviceIsStillRead) {
    Session run(project(kRtu115200, 500ms));
    run.line.devices()[0].behaviour.turnaround = 6ms;
    run.until(10s);
    for (const char* name : {"d1.f0", "d2.f0", "d3.f0"})
        EXPECT_EQ(run.slot(name).quality, value::Quality::good) << name;
    EXPECT_LE(run.age("d3.f0"), 600ms);
}

// docs/guarantees.md, "Late responses": lateness costs freshness, never truth.
TEST(Simulation, ADeviceThatIsAlwaysLateSpoilsNoValue) {
    model::Project description = project(kRtu115200, 200ms);
    for (model::Device& device : description.lines[0].devices) device.response_timeout = 20ms;
    Session run(std::move(description));
    run.line.devices()[1].behaviour.turnaround = 35ms;
    for (Duration t{}; t < 30s; t += 100ms) {
        run.until(t);
        for (const char* name : {"d1.i0", "d3.i2"}) {
            const value::Slot& slot = run.slot(name);
            if (!slot.good_at) continue;
            const Pattern pattern(DataType::int16, name);
            const auto now = std::get<std::int64_t>(pattern.at(*slot.good_at));
            EXPECT_NEAR(static_cast<double>(std::get<std::int64_t>(slot.value)), static_cast<double>(now), 10)
                << name;
        }
    }
    EXPECT_NE(run.slot("d2.i0").quality, value::Quality::good);
    EXPECT_EQ(run.slot("d3.i2").quality, value::Quality::good);
}

TEST(Simulation, ARefusedRequestIsBadTheRestOfTheDeviceGood) {
    Session run(project(kRtu115200, 200ms));
    run.line.devices()[0].behaviour.refusals = {
        {Area::holding_register, {100, 102}, wire::ExceptionCode::illegal_data_address}};
    run.until(5s);
    EXPECT_EQ(run.slot("d1.i0").quality, value::Quality::bad);
    EXPECT_EQ(run.slot("d1.i0").reason, value::exception_reason(2));
    EXPECT_EQ(run.slot("d1.f0").quality, value::Quality::good);
    EXPECT_EQ(run.master.line(0).device(0).state, poll::DeviceState::answering);
}

TEST(Simulation, AWriteReachesTheDeviceAndIsReadBack) {
    model::Project description = project(kRtu115200, 200ms);
    description.lines[0].devices[0].variables[0].write = Function::write_multiple_registers;
    Session run(std::move(description));
    run.until(1s);
    const value::WriteCommand command{1, *run.master.store().find("d1.f0"), 12.5, kNever};
    ASSERT_TRUE(run.master.write(run.now, command).has_value());
    run.until(2s);
    EXPECT_TRUE(value::same(run.slot("d1.f0").value, 12.5));
    const auto outcome = run.master.take_outcome();
    ASSERT_TRUE(outcome.has_value());
    EXPECT_EQ(outcome->result, value::CommandResult::done);
}

TEST(Simulation, TheSameRunTwiceIsTheSameToTheNanosecond) {
    const auto record = [](std::size_t chunk) {
        Session run(project(kRtu9600, 300ms), {.chunk = chunk});
        run.line.devices()[1].behaviour.dead = true;
        run.until(20s);
        return run.record.entries;
    };
    const auto first = record(1);
    EXPECT_EQ(first, record(1));
    EXPECT_EQ(first, record(0)) << "how the bytes are cut makes no difference either";
}

// However rarely the driver calls, things happen when they were due.
TEST(Simulation, LateCallsChangeNothing) {
    Session often(project(kRtu115200, 100ms)), rarely(project(kRtu115200, 100ms));
    for (Duration t{}; t <= 10s; t += 1ms) often.until(t);
    rarely.until(10s);
    EXPECT_EQ(often.record.entries, rarely.record.entries);
}

TEST(Simulation, AMonthPassesInSeconds) {
    Session run(project(kRtu115200, 120s, 2));
    run.line.set_observer(nullptr);
    run.until(30 * 24h);
    EXPECT_EQ(run.line.counters().requests, 4u * 30 * 24 * 30);
    EXPECT_EQ(run.line.counters().answers, run.line.counters().requests);
    EXPECT_EQ(run.slot("d2.i2").quality, value::Quality::good);
}

}  // namespace poller_test
}  // namespace takt::sim
