// The executor of a request table and the poller of its project: the same frames at the same nanosecond.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "table_sides.hpp"
#include "takt/table/owen.hpp"

namespace takt::sim {
namespace table_test {

model::Device floats(bool grouped) {
    auto result = device("D", 16);
    result.registers_per_request = 125;
    if (!grouped) result.strategy = model::Strategy::single;
    for (std::uint16_t i = 0; i < 10; ++i)
        result.variables.push_back(variable("V" + std::to_string(i), DataType::float32, 2 * i, 100ms));
    return result;
}

TEST(Table, Scenario1) {
    EXPECT_EQ(sent_by_both(project({floats(true)}, model::PollOrder::address), {}, 1s), 10U);
}

TEST(Table, Scenario2) {
    EXPECT_EQ(sent_by_both(project({floats(false)}, model::PollOrder::address), {}, 1s), 100U);
}

TEST(Table, Scenario3WithTriggers) {
    auto node = device("D", 16);
    node.variables = {variable("A", DataType::int16, 500, 100ms), variable("B", DataType::int16, 501, 100ms),
                      variable("C", DataType::int16, 506, 50ms, Function::read_input_registers)};
    node.variables[0].read_trigger = node.variables[1].read_trigger = 0;
    node.variables[2].read_trigger = 1;
    const Script script{{33ms, Set{"go", true}},
                        {34ms, Set{"read", true}},
                        {60ms, Set{"go", false}},
                        {70ms, Set{"go", true}}};
    EXPECT_EQ(sent_by_both(project({node}), script, 1s), 30U + 3U);
}

TEST(Table, SeveralPeriodsAndALineThatIsTooSlow) {
    std::vector<model::Device> devices;
    for (std::uint8_t d = 0; d < 4; ++d) {
        auto& made = devices.emplace_back(device("D" + std::to_string(d), static_cast<std::uint8_t>(9 - d)));
        for (const auto period : {0ms, 20ms, 50ms, 130ms})
            made.variables.push_back(variable("V" + std::to_string(d) + "_" + std::to_string(period.count()),
                                              DataType::int32,
                                              static_cast<std::uint16_t>(10 * period.count()), period));
    }
    for (const auto order : {model::PollOrder::deadline, model::PollOrder::address}) {
        auto described = project(devices, order);
        EXPECT_GT(sent_by_both(described, {}, 3s), 100U);
        described.lines[0].format = {9600, 8, wire::Parity::even, 1};
        EXPECT_GT(sent_by_both(described, {}, 3s), 50U);
    }
}

TEST(Table, WritesOnChangeAndByTrigger) {
    auto node = device("D", 1);
    node.status = 3;
    node.variables = {variable("A", DataType::int16, 0, 100ms), variable("B", DataType::int16, 1, 100ms),
                      variable("F", DataType::float32, 10, 100ms),
                      variable("P", DataType::boolean, 35, 100ms, Function::read_coils)};
    for (auto& v : node.variables) {
        v.write = Function::write_multiple_registers;
        v.write_on_change = true;
        v.order = {false, true};
    }
    node.variables[2].write_on_change = false;
    node.variables[2].write_trigger = 0;
    node.variables[3].write = Function::write_single_coil;
    const Script script{{1ms, Set{"A", std::int64_t{-5}}},
                        {150ms, Set{"B", std::int64_t{300}}},
                        {200ms, Set{"F", 1.5}},
                        {250ms, Set{"go", true}},
                        {300ms, Set{"P", true}},
                        {301ms, Set{"A", std::int64_t{7}}},
                        {301ms, Set{"P", false}}};
    EXPECT_GT(sent_by_both(project({node}), script, 1s), 10U);
}

// Between the two steps of a read-modify-write another device is due, its link is lost, or it is switched
// off.
TEST(Table, BitsOfARegister) {
    for (const bool mask : {true, false}) {
        auto node = device("D", 1);
        auto other = device("E", 2);
        other.variables = {variable("V", DataType::int16, 0, 20ms)};
        node.strategy = model::Strategy::optimal;
        node.fc22 = mask;
        node.read_modify_write = !mask;
        node.poll_enable = 2;
        node.order.high_byte_first = false;
        for (std::uint16_t i = 0; i < 3; ++i) {
            auto& bit = node.variables.emplace_back(
                variable("B" + std::to_string(i), DataType::boolean, 16 * 7 + i, 50ms));
            bit.order = node.order;
            bit.write = Function::write_single_register;
            bit.write_on_change = true;
            bit.status = 4;
        }
        const auto described = project({node, other});
        const Script alone{{100ms, Set{"B0", true}}, {100ms, Set{"B2", true}}, {300ms, Set{"B1", true}}};
        EXPECT_GT(sent_by_both(described, alone, 1s), 50U);
        for (Duration then = 100ms; then < 130ms; then += 1ms) {
            EXPECT_GT(sent_by_both(described, {{100ms, Set{"B1", true}}, {then, Set{"on", false}}}, 1s), 20U);
            const Script lost{{100ms, Set{"B1", true}}, {then, Link{false}}, {200ms, Link{true}}};
            EXPECT_GT(sent_by_both(described, lost, 1s), 20U);
        }
        const Script busy{{90ms, Behave{0, false, wire::ExceptionCode::server_device_busy}},
                          {100ms, Set{"B0", true}},
                          {150ms, Set{"B1", true}},
                          {400ms, Behave{0, false, {}}}};
        EXPECT_GT(sent_by_both(described, busy, 2s), 50U);
    }
}

TEST(Table, DefaultsOfMembersThatWereNeitherSetNorRead) {
    auto node = device("D", 1);
    node.variables = {variable("A", DataType::int16, 0, 100ms), variable("B", DataType::int16, 1, 100ms),
                      variable("F", DataType::float32, 10, 100ms)};
    for (auto& v : node.variables) {
        v.read.reset();
        v.write = Function::write_multiple_registers;
        v.write_trigger = 0;
        v.default_value = model::Constant{.number = -3, .integer = -3};
    }
    const Script script{{50ms, Set{"go", true}},
                        {80ms, Set{"go", false}},
                        {90ms, Set{"A", std::int64_t{7}}},
                        {100ms, Set{"go", true}}};
    EXPECT_EQ(sent_by_both(project({node}), script, 1s), 4U);
}

TEST(Table, ADeadDeviceAndOneThatComesBack) {
    std::vector<model::Device> devices;
    for (std::uint8_t d = 1; d <= 3; ++d) {
        auto& made = devices.emplace_back(device("D" + std::to_string(d), d));
        made.variables.push_back(variable("A" + std::to_string(d), DataType::int16, 0, 100ms));
        made.variables.push_back(variable("B" + std::to_string(d), DataType::float32, 20, 200ms));
    }
    devices[1].poll_enable = 2;
    const Script script{{0ms, Behave{0, true, {}}},
                        {1s, Behave{2, false, wire::ExceptionCode::server_device_busy}},
                        {2s, Set{"on", false}},
                        {3s, Set{"on", true}},
                        {20s, Behave{0, false, {}}},
                        {21s, Behave{2, false, wire::ExceptionCode::gateway_target_failed_to_respond}},
                        {30s, Link{false}},
                        {31s, Link{true}}};
    EXPECT_GT(sent_by_both(project(devices), script, 60s), 1000U);
}

// At any moment: the transaction in flight ends, and nothing follows.
TEST(Table, StopsAfterTheTransactionInFlight) {
    auto node = device("D", 1);
    node.variables = {variable("A", DataType::int16, 0, 0ms)};
    const auto described = project({node});
    for (Duration stop = 100ms; stop < 120ms; stop += 100us) {
        const auto side = table_side(described, plan::make_plan(described));
        Record record;
        SimulatedLine line(described.lines[0], side->engine());
        line.set_observer(&record);
        line.start(Instant{});
        line.advance(at(stop));
        const bool in_flight = !side->executor().idle();
        const std::size_t before = record.entries.size();
        side->executor().stop();
        line.advance(at(stop + 1s));
        EXPECT_TRUE(side->executor().idle());
        EXPECT_LE(record.entries.size(), before + (in_flight ? 2 : 0));
        EXPECT_EQ(side->executor().next_wakeup(), kNever);
    }
}

TEST(Table, StatusesOfTheExecutor) {
    auto node = device("D", 1);
    node.status = 3;
    node.variables = {variable("A", DataType::int16, 0, 100ms)};
    const auto described = project({node});
    const auto side = table_side(described, plan::make_plan(described));
    frames(described, *side, {{1s, Behave{0, true, {}}}}, 1s);
    EXPECT_EQ(side->word("state"), 0);
    const auto later = table_side(described, plan::make_plan(described));
    frames(described, *later, {{0ms, Behave{0, true, {}}}}, 3s);
    EXPECT_EQ(later->word("state"), 105);
}

// Exception 200 has the status 456. A variable that is not read gets it again when its device is back.
TEST(Table, AStatusAbove255OutlivesAnOutage) {
    auto node = device("D", 1);
    auto written = variable("W", DataType::int16, 5, 0ms);
    written.read.reset();
    written.write = Function::write_single_register;
    written.write_on_change = true;
    written.status = 4;
    node.variables = {variable("A", DataType::int16, 0, 100ms), written};
    const Script script{{1s, Behave{0, false, wire::ExceptionCode{200}}},
                        {1100ms, Set{"W", std::int64_t{7}}},
                        {2s, Behave{0, true, {}}},
                        {6s, Behave{0, false, {}}}};
    const auto described = project({node});
    EXPECT_GT(sent_by_both(described, script, 30s), 100U);
    const auto side = table_side(described, plan::make_plan(described));
    frames(described, *side, script, 30s);
    EXPECT_EQ(side->word("status"), 456);
}

// Two bits of a register, which are never read. A refused write concerns the one that was sent: its status
// shows it, and shows it again after an outage; that of the other one stays as it was.
TEST(Table, ARefusedWriteOfABitIsNoneOfItsNeighbour) {
    for (const bool mask : {true, false}) {
        auto node = device("D", 1);
        node.strategy = model::Strategy::optimal;
        node.fc22 = mask;
        node.read_modify_write = !mask;
        node.variables = {variable("A", DataType::int16, 0, 100ms)};
        for (std::uint16_t i = 0; i < 2; ++i) {
            auto& bit = node.variables.emplace_back(
                variable("B" + std::to_string(i), DataType::boolean, 16 * 7 + i, 0ms));
            bit.read.reset();
            bit.write = Function::write_single_register;
            bit.write_on_change = true;
            bit.status = 3U + i;
        }
        const Script refused{{1s, Behave{0, false, wire::ExceptionCode{200}}}, {1100ms, Set{"B0", true}}};
        Script back = refused;
        back.push_back({2s, Behave{0, true, {}}});
        back.push_back({6s, Behave{0, false, {}}});
        const auto described = project({node});
        for (const auto& script : {refused, back}) {
            EXPECT_GT(sent_by_both(described, script, 9s), 30U);
            const auto side = table_side(described, plan::make_plan(described));
            frames(described, *side, script, 9s);
            EXPECT_EQ(side->word("state"), 456);
            EXPECT_EQ(side->word("status"), 0);
        }
    }
}

Happening any_happening(const std::vector<std::string>& names, std::size_t devices) {
    const Duration when = std::chrono::milliseconds(*rc::gen::inRange(0, 4000));
    switch (*rc::gen::inRange(0, 8)) {
        case 0: return {when, Link{*rc::gen::arbitrary<bool>()}};
        case 1:
        case 2: {
            Behave behave{*rc::gen::inRange<std::size_t>(0, devices), *rc::gen::arbitrary<bool>(), {}};
            const auto code = *rc::gen::element(0, 0, 2, 4, 5, 6, 10, 11);
            if (code != 0) behave.refuses = static_cast<wire::ExceptionCode>(code);
            return {when, behave};
        }
        case 3:
        case 4:
            return {when,
                    Set{*rc::gen::element<std::string>("go", "read", "on"), *rc::gen::arbitrary<bool>()}};
        default:
            if (names.empty()) return {when, Set{"go", true}};
            return {when, Set{*rc::gen::elementOf(names), std::int64_t{*rc::gen::inRange(0, 2)}}};
    }
}

model::Device any_device(int number) {
    auto made = device("D" + std::to_string(number), static_cast<std::uint8_t>(number));
    if (*rc::gen::arbitrary<bool>()) made.poll_enable = 2;
    // One at most: which of two writes its status last, is no part of a table.
    if (number == 1 && *rc::gen::arbitrary<bool>()) made.status = 3;
    made.attempts = static_cast<std::uint16_t>(*rc::gen::inRange(1, 4));
    return made;
}

Script any_script(const std::vector<std::string>& names, std::size_t devices) {
    Script script;
    for (int i = *rc::gen::inRange(0, 15); i > 0; --i) script.push_back(any_happening(names, devices));
    std::ranges::stable_sort(script, {}, &Happening::at);
    return script;
}

RC_GTEST_PROP(Table, AnyProjectAnyTrouble, ()) {
    std::vector<model::Device> devices;
    std::vector<std::string> written;
    for (int d = *rc::gen::inRange(1, 4); d > 0; --d) {
        auto& made = devices.emplace_back(any_device(d));
        made.strategy =
            *rc::gen::element(model::Strategy::single, model::Strategy::classic, model::Strategy::optimal);
        made.gaps = *rc::gen::element(model::Gaps::never, model::Gaps::always);
        made.fc22 = *rc::gen::arbitrary<bool>();
        made.read_modify_write = !made.fc22;
        made.order.high_byte_first = *rc::gen::arbitrary<bool>();
        for (int v = *rc::gen::inRange(0, 6); v > 0; --v) {
            const bool coil = *rc::gen::inRange(0, 4) == 0;
            const bool bit = !coil && *rc::gen::inRange(0, 3) == 0;
            auto& made_variable = made.variables.emplace_back(
                variable("V" + std::to_string(d) + std::to_string(v),
                         coil || bit ? DataType::boolean : DataType::int16,
                         static_cast<std::uint16_t>(*rc::gen::inRange(0, bit ? 32 : 12)),
                         std::chrono::milliseconds(*rc::gen::element(0, 30, 100, 300)),
                         coil ? Function::read_coils : Function::read_holding_registers));
            made_variable.order = made.order;
            if (*rc::gen::arbitrary<bool>()) made_variable.read_trigger = 1;
            if (*rc::gen::arbitrary<bool>()) made_variable.status = 4;
            if (*rc::gen::arbitrary<bool>()) continue;
            made_variable.write = coil ? Function::write_single_coil : Function::write_multiple_registers;
            made_variable.write_on_change = *rc::gen::arbitrary<bool>();
            if (*rc::gen::arbitrary<bool>()) made_variable.write_trigger = 0;
            made_variable.safe_to_repeat = *rc::gen::arbitrary<bool>();
            if (*rc::gen::inRange(0, 3) == 0) made_variable.read.reset();
            if (*rc::gen::arbitrary<bool>())
                made_variable.default_value = model::Constant{.number = 1, .integer = 1};
            written.push_back(made_variable.name);
        }
    }
    const auto count = devices.size();
    const auto described =
        project(std::move(devices), *rc::gen::element(model::PollOrder::deadline, model::PollOrder::address));
    RC_ASSERT(compare(described, any_script(written, count), 6s).difference == "");
}

// The same for the table of a controller, as far as it holds the project.
RC_GTEST_PROP(Table, AnyControllerAnyTrouble, ()) {
    std::vector<model::Device> devices;
    std::vector<std::string> written;
    for (int d = *rc::gen::inRange(1, 4); d > 0; --d) {
        auto& made = devices.emplace_back(any_device(d));
        made.strategy = *rc::gen::element(model::Strategy::single, model::Strategy::classic);
        made.poll_period = std::chrono::milliseconds(*rc::gen::element(0, 40, 100));
        made.response_timeout_set = true;
        made.read_modify_write = true;
        made.order.high_byte_first = *rc::gen::arbitrary<bool>();
        const Duration pause = std::max<Duration>(made.poll_period, 1ms);
        made.backoff = model::Backoff{.first = pause, .limit = pause};
        for (int v = *rc::gen::inRange(0, 6); v > 0; --v) {
            const int kind = *rc::gen::inRange(0, 5);  // 0: a coil, 4: a bit of a register
            const auto type = kind % 4 == 0 ? DataType::boolean
                              : kind == 1   ? DataType::float32
                                            : DataType::int16;
            auto& made_variable = made.variables.emplace_back(
                variable("V" + std::to_string(d) + std::to_string(v), type, static_cast<std::uint16_t>(3 * v),
                         *rc::gen::element(Duration(made.poll_period), Duration(30ms), Duration(300ms)),
                         kind == 0 ? Function::read_coils : Function::read_holding_registers));
            if (kind == 4) made_variable.register_number = static_cast<std::uint16_t>(40 + v);
            made_variable.order = made.order;
            if (*rc::gen::arbitrary<bool>()) made_variable.read_trigger = 1;
            if (*rc::gen::arbitrary<bool>()) made_variable.status = 4;
            if (type == DataType::float32 || *rc::gen::arbitrary<bool>()) continue;
            made_variable.write =
                kind == 0 ? Function::write_single_coil : Function::write_multiple_registers;
            made_variable.write_on_change = *rc::gen::arbitrary<bool>();
            made_variable.write_trigger =
                made_variable.write_on_change ? std::nullopt : std::optional<model::LocalIndex>(0);
            written.push_back(made_variable.name);
        }
    }
    const auto count = devices.size();
    const auto described = project(std::move(devices), model::PollOrder::address);
    const auto plan = plan::make_plan(described);
    const auto built = table::build_owen(described, plan);
    RC_PRE(built.findings.empty());
    const auto owen = table::write_owen(built.table);
    const auto view = table::OwenView::open(owen).value();
    table::Image image(table::expanded_size(view));
    RC_ASSERT(table::expand(view, image).has_value());
    // A controller knows no response times, which a plan counts: near a whole load it may think otherwise of
    // the order of late reads.
    RC_PRE((plan.lines[0].utilization > 1) == (table::View::open(image)->line(0).utilization > 1));
    const auto compared = compare(described, plan, *TableSide::of_controller(described, std::move(image)),
                                  any_script(written, count), 6s);
    RC_ASSERT(compared.difference == "");
}

}  // namespace table_test
}  // namespace takt::sim
