// Measured on the simulated bus and compared with the bounds of the plan: how long a write waits, and what a
// dead device costs the others.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/poll/master.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::sim {
namespace response_test {

using namespace std::chrono_literals;
using wire::Function;

constexpr Duration kTurnaround = 20ms;

model::Variable registers(std::string name, std::uint16_t start, Duration period) {
    model::Variable made;
    made.name = std::move(name);
    made.register_number = start;
    made.read = Function::read_holding_registers;
    made.period = period;
    return made;
}

model::Device device(std::uint8_t address, int count, Duration period) {
    model::Device made;
    made.name = "d" + std::to_string(address);
    made.address = UnitId{address};
    made.turnaround = kTurnaround;
    made.strategy = model::Strategy::classic;
    made.group_requests = true;
    made.registers_per_request = 125;
    for (int i = 0; i < count; ++i)
        made.variables.push_back(
            registers(made.name + "." + std::to_string(i), static_cast<std::uint16_t>(i), period));
    return made;
}

model::Project project(std::vector<model::Device> devices) {
    model::Project made;
    made.host = {Duration::zero(), Duration::zero()};
    model::Line line;
    line.name = "line";
    line.transport = model::Transport::simulated;
    line.format = {19200, 8, wire::Parity::even, 1};
    line.devices = std::move(devices);
    made.lines.push_back(line);
    return made;
}

struct Session {
    explicit Session(model::Project description)
        : project(std::move(description)),
          plan(plan::make_plan(project)),
          proved(plan::guarantee(project, plan).at(0)),
          master(project, plan),
          line(project.lines[0], master.line(0)) {
        for (const auto& one : project.lines[0].devices)
            line.devices().find(one.address)->behaviour.turnaround = kTurnaround;
        line.set_observer(&record);
        line.start(Instant{});
    }
    /// The index of the request that reads (writes) from that device.
    [[nodiscard]] std::size_t request(std::size_t device, bool writes = false) const {
        const auto& requests = plan.lines[0].requests;
        for (std::size_t i = 0; i < requests.size(); ++i)
            if (requests[i].device == device && requests[i].write.has_value() == writes) return i;
        return requests.size();
    }

    model::Project project;
    plan::Plan plan;
    plan::LineGuarantee proved;
    poll::Master master;
    SimulatedLine line;
    Record record;
};

// B is what R is above the write's own transaction: the longest transaction that may be in flight.
TEST(Response, AWriteWaitsForOneTransactionAtMostAsLongAsProved) {
    auto short_one = device(1, 2, 0ms);
    auto long_one = device(2, 60, 0ms);
    auto periodic = device(4, 10, 150ms);
    auto written = device(3, 1, 1h);
    auto& variable = written.variables[0];
    variable.read.reset();
    variable.write = Function::write_multiple_registers;
    variable.write_on_change = true;
    variable.admission = model::RateLimit{.min_interval = 200ms};
    Session run(project({short_one, long_one, written, periodic}));
    const auto& bound = run.proved.requests[run.request(2, true)];
    ASSERT_TRUE(bound.response);
    const Duration blocking = *bound.response - bound.transaction;
    const auto slot = *run.master.store().find("d3.0");
    Duration longest{};
    for (std::int64_t i = 1; i <= 400; ++i) {
        const Instant ordered = at(i * 250ms + i * 733us);
        run.line.advance(ordered);
        ASSERT_TRUE(run.master.set(ordered, slot, std::int64_t{i}));
        run.record.entries.clear();
        run.line.advance(ordered + blocking + 20ms);  // transmissions are reported at their end
        const auto sent = std::ranges::find_if(run.record.entries, [](const Record::Entry& entry) {
            return entry.sender == 0 && entry.bytes[0] == 3;
        });
        ASSERT_NE(sent, run.record.entries.end())
            << "write " << i << " waits longer than " << blocking.count();
        const auto between = std::count_if(run.record.entries.begin(), sent, [&](const Record::Entry& entry) {
            return entry.sender == 0 && entry.start > ordered;
        });
        EXPECT_EQ(between, 0) << "nothing begins after the write was ordered and before it is sent";
        longest = std::max(longest, sent->start - ordered);
    }
    EXPECT_LE(longest, blocking);
    EXPECT_GE(longest, blocking - blocking / 50) << "the bound is reached";
}

TEST(Response, TheOthersStayWithinTheirGuaranteeWhileOneOfTenIsDead) {
    std::vector<model::Device> devices;
    for (std::uint8_t address = 1; address <= 10; ++address)
        devices.push_back(device(address, 4 * address, 1500ms));
    Session run(project(devices));
    const Instant dies = at(20s);
    run.line.advance(dies);
    run.line.devices().find(UnitId{5})->behaviour.dead = true;
    run.line.advance(at(200s));
    std::map<std::uint8_t, Instant> last;
    std::map<std::uint8_t, Duration> longest;
    std::size_t asked_dead = 0;
    for (const auto& entry : run.record.entries) {
        const std::uint8_t unit = entry.bytes[0];
        if (entry.sender == 0) {
            if (unit == 5 && entry.start > dies) ++asked_dead;
            continue;
        }
        if (last.contains(unit)) longest[unit] = std::max(longest[unit], entry.end - last[unit]);
        last[unit] = entry.end;
    }
    ASSERT_EQ(longest.size(), 10U);
    for (std::size_t d = 0; d < 10; ++d) {
        const auto unit = static_cast<std::uint8_t>(d + 1);
        if (unit == 5) continue;
        const auto& bound = run.proved.requests[run.request(d)];
        ASSERT_TRUE(bound.response_with_dead) << "device " << d;
        EXPECT_LE(longest[unit], 1500ms + *bound.response_with_dead) << "device " << d;
        EXPECT_GT(last[unit], at(198s)) << "device " << d;
    }
    EXPECT_LE(asked_dead, 3U + 120U) << "attempts, and at most one probe in each period";
    EXPECT_GE(asked_dead, 8U);
}

}  // namespace response_test
}  // namespace takt::sim
