// A plan goes into a table and comes out the same.
#include "takt/table/build.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "project.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/table/restore.hpp"

namespace takt::table {
namespace build_test {

using namespace test;

auto fields(const plan::Request& r) {
    return std::tuple(r.device, r.variables, r.read, r.write, r.start, r.quantity, r.period, r.phase,
                      r.stream, r.deadline, r.read_trigger, r.write_trigger, r.status, r.write_on_change,
                      r.admission, r.write_start, r.write_quantity, r.read_modify_write, r.bus_time,
                      r.request_bytes, r.response_bytes);
}

auto fields(const model::Variable& v) {
    return std::tuple(v.name, v.type, v.area, v.start(), v.registers, v.read, v.write, v.write_on_change,
                      v.hold_last, v.retain, v.used, v.order, v.scale, v.offset, v.dead_band, v.verify,
                      v.safe_to_repeat, v.unit, v.default_value, v.period, v.read_trigger, v.write_trigger,
                      v.status);
}

auto fields(const model::Device& d) {
    return std::tuple(d.name, d.address, d.poll_period, d.response_timeout, d.turnaround, d.round_trip,
                      d.attempts, d.in_flight, d.order, d.poll_enable, d.status, d.fc22, d.fc23, d.gaps,
                      d.read_modify_write);
}

auto fields(const model::Line& l) {
    return std::tuple(l.name, l.transport, l.port, l.tcp_port, l.framing, l.format, l.rs485, l.order,
                      l.request_gap, l.frame_gap);
}

void expect_same(const model::Project& a, const model::Project& b) {
    ASSERT_EQ(a.locals.size(), b.locals.size());
    for (std::size_t i = 0; i < a.locals.size(); ++i) {
        EXPECT_EQ(a.locals[i].name, b.locals[i].name);
        EXPECT_EQ(a.locals[i].type, b.locals[i].type);
        EXPECT_EQ(a.locals[i].default_value, b.locals[i].default_value);
        EXPECT_EQ(a.locals[i].admission, b.locals[i].admission);
    }
    ASSERT_EQ(a.lines.size(), b.lines.size());
    for (std::size_t l = 0; l < a.lines.size(); ++l) {
        EXPECT_TRUE(fields(a.lines[l]) == fields(b.lines[l]));
        ASSERT_EQ(a.lines[l].devices.size(), b.lines[l].devices.size());
        for (std::size_t d = 0; d < a.lines[l].devices.size(); ++d) {
            const auto& x = a.lines[l].devices[d];
            const auto& y = b.lines[l].devices[d];
            EXPECT_TRUE(fields(x) == fields(y)) << x.name;
            ASSERT_EQ(x.variables.size(), y.variables.size());
            for (std::size_t v = 0; v < x.variables.size(); ++v)
                EXPECT_TRUE(fields(x.variables[v]) == fields(y.variables[v])) << x.variables[v].name;
        }
    }
}

void expect_same(const plan::Plan& a, const plan::Plan& b) {
    ASSERT_EQ(a.lines.size(), b.lines.size());
    for (std::size_t l = 0; l < a.lines.size(); ++l) {
        const auto& x = a.lines[l];
        const auto& y = b.lines[l];
        EXPECT_EQ(x.request_count, y.request_count);
        EXPECT_EQ(x.ungrouped_requests, y.ungrouped_requests);
        EXPECT_EQ(x.cycle, y.cycle);
        EXPECT_EQ(x.longest_round, y.longest_round);
        EXPECT_EQ(x.utilization, y.utilization);
        ASSERT_EQ(x.requests.size(), y.requests.size());
        for (std::size_t r = 0; r < x.requests.size(); ++r)
            EXPECT_TRUE(fields(x.requests[r]) == fields(y.requests[r])) << r;
    }
}

constexpr std::array kTypes{DataType::int16,  DataType::uint16,  DataType::int32,  DataType::uint32,
                            DataType::int64,  DataType::float32, DataType::uint64, DataType::float64,
                            DataType::string, DataType::boolean};

model::Variable any_variable(int number) {
    const auto type = *rc::gen::elementOf(kTypes);
    auto result = variable("V" + std::to_string(number), type,
                           static_cast<std::uint16_t>(*rc::gen::inRange(0, 4000)), std::nullopt);
    if (type == DataType::string) result.registers = static_cast<std::uint16_t>(*rc::gen::inRange(1, 20));
    const bool coil = type == DataType::boolean && *rc::gen::arbitrary<bool>();
    if (type == DataType::boolean) result.bit = static_cast<std::uint8_t>(*rc::gen::inRange(0, 16));
    result.area = coil ? wire::Area::coil : wire::Area::holding_register;
    result.read = coil ? Function::read_coils : Function::read_holding_registers;
    if (*rc::gen::arbitrary<bool>() && (coil || type != DataType::boolean)) {
        result.write = coil ? Function::write_multiple_coils : Function::write_multiple_registers;
        result.write_on_change = *rc::gen::arbitrary<bool>();
        if (*rc::gen::arbitrary<bool>()) result.write_trigger = 0;
    }
    if (*rc::gen::inRange(0, 4) == 0) result.read_trigger = 1;
    if (*rc::gen::inRange(0, 4) == 0) result.status = 2;
    result.period = std::chrono::milliseconds(*rc::gen::element(0, 50, 100, 1000));
    result.used = *rc::gen::inRange(0, 5) != 0;
    result.hold_last = *rc::gen::arbitrary<bool>();
    result.safe_to_repeat = *rc::gen::arbitrary<bool>();
    result.order = {*rc::gen::arbitrary<bool>(), *rc::gen::arbitrary<bool>()};
    if (type == DataType::int16 && *rc::gen::arbitrary<bool>()) {
        const auto value = *rc::gen::inRange(-300, 300);
        result.default_value = model::Constant{.number = static_cast<double>(value), .integer = value};
    }
    if (*rc::gen::arbitrary<bool>()) result.unit = "°C";
    return result;
}

model::Project any_project() {
    std::vector<model::Device> devices;
    int number = 0;
    for (int d = *rc::gen::inRange(1, 4); d > 0; --d) {
        auto& made = devices.emplace_back(
            device("D" + std::to_string(d), static_cast<std::uint8_t>(10 * d + *rc::gen::inRange(0, 9))));
        made.strategy =
            *rc::gen::element(model::Strategy::single, model::Strategy::classic, model::Strategy::optimal);
        if (*rc::gen::arbitrary<bool>()) made.turnaround = std::chrono::milliseconds(7);
        if (*rc::gen::arbitrary<bool>()) made.poll_enable = 0;
        for (int v = *rc::gen::inRange(0, 12); v > 0; --v) made.variables.push_back(any_variable(number++));
    }
    auto result = project(std::move(devices));
    result.locals = {local("go"), local("read"), local("state", DataType::int16)};
    if (*rc::gen::arbitrary<bool>()) result.locals[0].admission = model::RateLimit{50ms, 3};
    return result;
}

TEST(Build, KeepsTheProvedAgeElseTheGreatestAllowedOne) {
    auto one = device("D", 1);
    one.variables = {variable("Proved", DataType::int16, 0, Function::read_holding_registers),
                     variable("Allowed", DataType::int16, 8, Function::read_holding_registers),
                     variable("Free", DataType::int16, 16, Function::read_holding_registers)};
    one.variables[0].max_age = one.variables[1].max_age = 7s;
    const auto described = project({one});
    auto planned = plan::make_plan(described);
    planned.lines[0].ages = {{2s, std::nullopt, std::nullopt}};
    const auto image = build(described, planned, options(described));
    ASSERT_TRUE(image);
    const auto view = View::open(*image);
    ASSERT_TRUE(view);
    const auto restored = project_of(*view).lines[0].devices[0].variables;
    EXPECT_EQ(restored[0].max_age, 2s);
    EXPECT_EQ(restored[1].max_age, 7s);
    EXPECT_EQ(restored[2].max_age, std::nullopt);
}

// The wait for a response and the deadlines are those of the poller.
TEST(Build, HasTheTimesOfThePlan) {
    auto one = device("D", 1);
    one.turnaround = 1ms;  // shorter than t3.5
    one.variables = {variable("A", DataType::int16, 0, Function::read_holding_registers)};
    one.variables[0].deadline = 60ms;
    auto described = project({one});
    described.lines[0].transport = model::Transport::serial;
    described.backoff.first = 3s;
    const auto planned = plan::make_plan(described);
    const auto image = build(described, planned, options(described));
    ASSERT_TRUE(image);
    const auto view = View::open(*image);
    ASSERT_TRUE(view);
    const auto record = view->device(0);
    const auto& line = described.lines[0];
    EXPECT_EQ(Duration(record.wait), plan::answer_wait(described, line, line.devices[0]));
    EXPECT_EQ(Duration(record.wait), 1750us);
    EXPECT_EQ(Duration(record.backoff_first), 3s);
    EXPECT_EQ(Duration(view->entry(0).deadline), 60ms);
}

// A running table counts transactions that are longer than the C of the project.
TEST(Build, KeepsTheLongestTimeOfATransaction) {
    auto written = device("A", 1);
    written.turnaround = 3ms;
    auto round_trip = device("B", 2);
    round_trip.measured_round_trip =
        model::MeasuredRoundTrip{.longest = 4ms, .usual = 1ms, .exchanges = 5000, .in_flight = 2};
    auto learnt = device("C", 3);
    learnt.learn_turnaround = true;
    learnt.times.measured = {.exchanges = 300, .longest = 7ms};
    auto unknown = device("D", 4);
    auto described = project({written, round_trip, learnt, unknown});
    for (auto& device : described.lines[0].devices)
        device.variables = {
            variable(device.name + "v", DataType::int16, 0, Function::read_holding_registers)};
    described.host.overhead = 5ms;
    for (const auto in_flight : {std::uint16_t{1}, std::uint16_t{4}}) {
        described.lines[0].transport = model::Transport::tcp;
        described.lines[0].framing = wire::Framing::tcp;
        described.lines[0].devices[1].in_flight = in_flight;
        const auto planned = plan::make_plan(described);
        const auto image = build(described, planned, options(described));
        ASSERT_TRUE(image);
        const auto view = View::open(*image);
        ASSERT_TRUE(view);
        const auto restored = project_of(*view);
        EXPECT_EQ(restored.host.overhead, 5ms);
        const auto before = plan::guarantee(described, planned).at(0);
        const auto after = plan::guarantee(restored, plan_of(*view)).at(0);
        ASSERT_EQ(before.requests.size(), after.requests.size());
        for (std::size_t r = 0; r < before.requests.size(); ++r)
            EXPECT_EQ(before.requests[r].transaction, after.requests[r].transaction) << r;
    }
}

RC_GTEST_PROP(Build, PlanAndProjectComeBack, ()) {
    const auto described = any_project();
    const auto planned = plan::make_plan(described);
    const auto image = build(described, planned, options(described));
    RC_ASSERT(image.has_value());
    const auto view = View::open(*image);
    RC_ASSERT(view.has_value());
    expect_same(described, project_of(*view));
    expect_same(planned, plan_of(*view));
    RC_ASSERT(!::testing::Test::HasFailure());
}

TEST(Build, IsTheSameEachTime) {
    auto boiler = device("Boiler", 16);
    boiler.variables.push_back(variable("V", DataType::float32, 0, Function::read_holding_registers));
    const auto described = project({boiler});
    EXPECT_EQ(image_of(described).value(), image_of(described).value());
}

TEST(Build, DoesWithoutNames) {
    auto boiler = device("Boiler", 16);
    boiler.variables.push_back(variable("Var", DataType::float32, 0, Function::read_holding_registers));
    const auto described = project({boiler});
    auto without = options(described);
    without.names = false;
    const auto image = build(described, plan::make_plan(described), without).value();
    EXPECT_LT(image.size(), image_of(described)->size());
    const auto restored = project_of(View::open(image).value());
    EXPECT_EQ(restored.lines[0].devices[0].name, "device0");
    EXPECT_EQ(restored.lines[0].devices[0].variables[0].name, "item0");
}

}  // namespace build_test
}  // namespace takt::table
