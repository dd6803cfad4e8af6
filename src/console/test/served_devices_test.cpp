// Faults and values of the devices of a project, by name.
#include "takt/console/served_devices.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "support.hpp"
#include "takt/console/fault_commands.hpp"
#include "takt/sim/devices.hpp"

namespace takt::console {
namespace served_devices_test {

using namespace std::chrono_literals;
using test::english;
using wire::Area;

model::Variable variable(std::string name, DataType type, Area area, std::uint16_t start) {
    model::Variable made;
    made.name = std::move(name);
    made.type = type;
    made.area = area;
    made.read = wire::read_function(area);
    made.registers = static_cast<std::uint16_t>(register_count(type, 1));
    made.register_number = is_bit_area(area) ? static_cast<std::uint16_t>(start / 16) : start;
    if (is_bit_area(area)) made.bit = static_cast<std::uint8_t>(start % 16);
    return made;
}

model::Line line_of(const char* name) {
    model::Line line;
    line.name = name;
    auto& meter = line.devices.emplace_back();
    meter.name = "Meter";
    meter.address = UnitId{1};
    return line;
}

class Served : public testing::Test {
protected:
    Served() {
        auto& variables = a_.devices[0].variables;
        variables.push_back(variable("Pressure", DataType::float32, Area::holding_register, 0));
        variables.back().scale = 0.1;
        variables.push_back(variable("Alarm", DataType::boolean, Area::holding_register, 20));
        variables.back().bit = 3;
        variables.push_back(variable("Pump", DataType::boolean, Area::coil, 21));
        auto& boiler = a_.devices.emplace_back();
        boiler.name = "Boiler 2";
        boiler.address = UnitId{2};
        boiler.variables.push_back(variable("T 1", DataType::int16, Area::input_register, 7));
        in_a_ = std::make_unique<sim::Devices>(a_);
        in_b_ = std::make_unique<sim::Devices>(b_);
        for (std::size_t i = 0; i < in_a_->size(); ++i) served_->add(a_, i, (*in_a_)[i]);
        served_->add(b_, 0, (*in_b_)[0]);
    }

    std::string ask(const std::string& command) {
        std::string answer;
        const auto done = execute_(command, [&](const Answer& given) { answer = given.line; }, english());
        return done ? answer
                    : std::string(name(done.error().code)) + ' ' + std::string(done.error().subject.view());
    }

    model::Line a_ = line_of("A");
    model::Line b_ = line_of("B");
    std::unique_ptr<sim::Devices> in_a_;
    std::unique_ptr<sim::Devices> in_b_;
    std::shared_ptr<ServedDevices> served_ = std::make_shared<ServedDevices>();
    std::shared_ptr<sim::AnswerFaults> faults_ = std::make_shared<sim::AnswerFaults>();
    Execute execute_ = fault_commands(faults_, served_, [] { return Instant{5s}; }, [] {});
};

TEST_F(Served, ValuesAreSetInTheirTypeAndStay) {
    EXPECT_EQ(ask("set Pressure 12.5"), "ok Pressure 12.5\n");
    EXPECT_EQ((*in_a_)[0].content(Instant{9s}, Area::holding_register, 0, 2),
              (std::vector<std::uint16_t>{0, 0x42FA}))
        << "125 of the scale 0.1, low register first, also later";
    EXPECT_EQ(ask("set \"T 1\" -7"), "ok \"T 1\" -7\n");
    EXPECT_EQ(ask("get \"T 1\""), "ok \"T 1\" -7\n");
    EXPECT_EQ(ask("set Pump 1"), "ok Pump true\n");
    EXPECT_EQ((*in_a_)[0].content(Instant{9s}, Area::coil, 21, 1), (std::vector<std::uint16_t>{1}));
    EXPECT_EQ(ask("set \"T 1\" 70000").substr(0, 8), "overflow");
    EXPECT_EQ(ask("set \"T 1\" warm").substr(0, 6), "syntax");
    EXPECT_EQ(ask("set Nothing 1"), "not_found Nothing");
    EXPECT_EQ(ask("get Meter"), "not_found Meter") << "a device has no value";
}

TEST_F(Served, ABitLeavesTheOthersOfItsRegister) {
    auto& device = (*in_a_)[0];
    const std::vector<std::uint16_t> before{0x8001};
    ASSERT_TRUE(device.change(Instant{1s}, Area::holding_register, 20, before));
    EXPECT_EQ(ask("set Alarm true"), "ok Alarm true\n");
    EXPECT_EQ(device.content(Instant{9s}, Area::holding_register, 20, 1),
              (std::vector<std::uint16_t>{0x8009}));
    EXPECT_EQ(ask("set Alarm 0"), "ok Alarm false\n");
    EXPECT_EQ(device.content(Instant{9s}, Area::holding_register, 20, 1), before);
}

TEST_F(Served, ABitOfARegisterWithTheLowByteFirst) {
    a_.devices[0].variables[1].order.high_byte_first = false;
    EXPECT_EQ(ask("set Alarm true"), "ok Alarm true\n");
    EXPECT_EQ(ask("get Alarm"), "ok Alarm true\n");
    EXPECT_EQ((*in_a_)[0].content(Instant{9s}, Area::holding_register, 20, 1),
              (std::vector<std::uint16_t>{0x0800}));
}

TEST_F(Served, FaultsHaveTheNameOfADeviceOrAVariable) {
    EXPECT_EQ(ask("fault add Boiler 2:silence:10%"), "ok \"Boiler 2\":silence:10%\n");
    EXPECT_EQ(ask("fault add \"Boiler 2\":cut@10s"), "ok \"Boiler 2\":silence:10% \"Boiler 2\":cut@10s\n");
    EXPECT_EQ(ask("fault clear \"Boiler 2\""), "ok\n");
    EXPECT_EQ(ask("fault add Pressure:exception=4"), "ok Pressure:exception=4\n");
    EXPECT_EQ(ask("fault add B/Meter:delay=1s"), "ok Pressure:exception=4 B/Meter:delay=1s\n");
    const auto rules = faults_->rules();
    ASSERT_EQ(rules.size(), 2U);
    EXPECT_EQ(rules[0].scope, (sim::FaultScope{"Pressure", "A", UnitId{1},
                                               sim::FaultScope::Items{Area::holding_register, 0, 2}}));
    EXPECT_EQ(rules[1].scope, (sim::FaultScope{"B/Meter", "B", UnitId{1}, std::nullopt}));
    EXPECT_EQ(ask("fault clear"), "ok\n");
    EXPECT_EQ(ask("fault add silence:5%"), "ok silence:5%\n") << "of all devices, as before";
}

TEST_F(Served, WrongFaultsChangeNothing) {
    const auto of_several = ask("fault add Meter:silence");
    EXPECT_NE(of_several.find("A/Meter, B/Meter"), std::string::npos) << of_several;
    EXPECT_EQ(ask("fault add Nothing:silence"), "not_found Nothing");
    EXPECT_EQ(ask("fault clear Nothing"), "not_found Nothing");
    EXPECT_EQ(ask("fault add Pressure:bad_crc").substr(0, 6), "syntax") << "a frame does not show its items";
    for (const auto* const wrong : {"fault add A/Meter:", "fault add A/Meter:dog", "fault add :silence",
                                    "fault list x", "get", "set Pressure", "status"})
        EXPECT_FALSE(ask(wrong).starts_with("ok")) << wrong;
    EXPECT_TRUE(faults_->rules().empty());
}

TEST(ServedDevices, WithoutDevicesTheCommandsHaveNoNames) {
    const auto faults = std::make_shared<sim::AnswerFaults>();
    const auto execute =
        fault_commands(faults, std::make_shared<ServedDevices>(), [] { return Instant{1s}; }, [] {});
    EXPECT_EQ(execute("fault clear a", [](const Answer&) {}, english()).error().code, Code::syntax);
    for (const auto* const wrong : {"set a 1", "get a"}) {
        std::string answer;
        EXPECT_TRUE(execute(wrong, [&](const Answer& given) { answer = given.line; }, english()));
        EXPECT_NE(answer.find("allowed: fault add FAULT, fault clear, fault list, quit"), std::string::npos)
            << answer;
    }
}

}  // namespace served_devices_test
}  // namespace takt::console
