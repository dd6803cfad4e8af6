#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support.hpp"
#include "takt/sim/devices.hpp"
#include "takt/sim/pattern.hpp"
#include "takt/value/codec.hpp"

namespace takt::sim {
namespace device_test {

using namespace std::chrono_literals;
using wire::Area;

model::Variable variable(std::string name, DataType type, Area area, std::uint16_t number) {
    model::Variable result;
    result.name = std::move(name);
    result.type = type;
    result.area = area;
    result.register_number = number;
    result.registers = static_cast<std::uint16_t>(register_count(type, 4));
    return result;
}

model::Line line() {
    model::Device device;
    device.name = "Boiler";
    device.address = UnitId{16};
    device.turnaround = 7ms;
    device.variables = {variable("Level", DataType::uint16, Area::input_register, 100),
                        variable("Temperature", DataType::float32, Area::holding_register, 10),
                        variable("Energy", DataType::uint64, Area::holding_register, 12),
                        variable("Label", DataType::string, Area::holding_register, 40),
                        variable("Pump", DataType::boolean, Area::coil, 2),
                        variable("Alarm", DataType::boolean, Area::holding_register, 50)};
    device.variables[4].bit = 3;
    device.variables[5].bit = 15;
    device.variables[5].used = false;
    model::Line result;
    result.transport = model::Transport::simulated;
    result.devices = {device};
    return result;
}

wire::Pdu ask(Devices& devices, std::initializer_list<std::uint8_t> pdu, Instant t = {},
              std::uint8_t unit = 16) {
    serve::Context context;
    context.time = t;
    context.unit = UnitId{unit};
    const wire::Pdu request(pdu);
    const serve::Answer answer = devices.handle(context, wire::RequestView(request.span()));
    return answer.kind == serve::Answer::Kind::response ? answer.pdu : wire::Pdu{};
}

double temperature(Devices& devices, Instant t) {
    const wire::Pdu pdu = ask(devices, {0x03, 0, 10, 0, 2}, t);
    EXPECT_EQ(pdu.size(), 6u);
    value::Layout layout;
    layout.type = DataType::float32;
    const std::array<std::uint16_t, 2> registers{static_cast<std::uint16_t>(pdu[2] << 8 | pdu[3]),
                                                 static_cast<std::uint16_t>(pdu[4] << 8 | pdu[5])};
    return std::get<double>(value::decode(layout, registers).value());
}

class AddressAndMoment final : public ValueSource {
public:
    std::uint16_t item(UnitId, Area, std::uint16_t address, Instant t) const override {
        return static_cast<std::uint16_t>(address * 100 + t.time_since_epoch() / 1s);
    }
};

TEST(Device, FollowsASourceInThePlaceOfItsPatternsExceptWhereItWasWritten) {
    const AddressAndMoment source;
    Devices devices(line(), {.source = &source});
    EXPECT_EQ(ask(devices, {0x03, 0, 10, 0, 2}, at(3s)), (wire::Pdu{0x03, 4, 0x03, 0xEB, 0x04, 0x4F}));
    EXPECT_EQ(ask(devices, {0x01, 0, 35, 0, 1}, at(4s)), (wire::Pdu{0x01, 1, 0}));
    EXPECT_EQ(ask(devices, {0x01, 0, 35, 0, 1}, at(5s)), (wire::Pdu{0x01, 1, 1}));
    ask(devices, {0x06, 0, 10, 0xAB, 0xCD}, at(6s));
    EXPECT_EQ(ask(devices, {0x03, 0, 10, 0, 2}, at(7s)), (wire::Pdu{0x03, 4, 0xAB, 0xCD, 0x04, 0x53}));
}

/// Knows two variables of the line; keeps what was written.
struct Plant final : PlantModel {
    std::optional<double> value(std::string_view variable, Instant t) const override {
        if (variable == "Level") return 41.5;
        return variable == "Pump" ? std::optional(t == at(1s) ? 1.0 : 0.0) : std::nullopt;
    }
    void on_written(std::string_view variable, double value, Instant) override {
        written.emplace_back(variable, value);
    }
    std::vector<std::pair<std::string, double>> written;
};

TEST(Device, FollowsAModelInThePlaceOfItsPatternsAndReportsWrites) {
    auto scaled = line();
    scaled.devices[0].variables[0].scale = 0.1;
    Plant plant;
    Devices devices(scaled);
    devices[0].set_model(&plant);
    EXPECT_EQ(ask(devices, {0x04, 0, 100, 0, 1}), (wire::Pdu{0x04, 2, 0x01, 0x9F})) << "415 × 0.1";
    EXPECT_EQ(ask(devices, {0x01, 0, 35, 0, 1}, at(1s)), (wire::Pdu{0x01, 1, 1}));
    EXPECT_EQ(ask(devices, {0x01, 0, 35, 0, 1}, at(2s)), (wire::Pdu{0x01, 1, 0}));
    Devices alone(scaled);
    EXPECT_EQ(ask(devices, {0x03, 0, 10, 0, 2}), ask(alone, {0x03, 0, 10, 0, 2}))
        << "it does not know this one";
    ask(devices, {0x05, 0, 35, 0xFF, 0x00}, at(2s));
    ask(devices, {0x10, 0, 10, 0, 2, 4, 0, 0, 0x41, 0x20});
    const std::vector<std::pair<std::string, double>> wanted{{"Pump", 1}, {"Temperature", 10}};
    EXPECT_EQ(plant.written, wanted);
    EXPECT_EQ(ask(devices, {0x01, 0, 35, 0, 1}, at(2s)), (wire::Pdu{0x01, 1, 1}))
        << "the written value stays";
}

TEST(Device, ShowsABitOfARegisterWithTheLowByteFirst) {
    auto described = line();
    auto& pump = described.devices[0].variables[4];
    pump.area = Area::holding_register;
    pump.register_number = 60;
    pump.order.high_byte_first = false;
    Plant plant;
    Devices devices(described);
    devices[0].set_model(&plant);
    EXPECT_EQ(ask(devices, {0x03, 0, 60, 0, 1}, at(1s)), (wire::Pdu{0x03, 2, 0x08, 0}));
    EXPECT_EQ(ask(devices, {0x03, 0, 60, 0, 1}, at(2s)), (wire::Pdu{0x03, 2, 0, 0}));
}

TEST(Device, OffersOnlyWhatItsVariablesCover) {
    struct Row {
        std::uint8_t function, start, count;
        bool exists;
    };
    constexpr Row kRows[] = {{3, 10, 2, true},  {3, 10, 6, true},  {3, 11, 1, true},  {3, 9, 1, false},
                             {3, 16, 1, false}, {3, 10, 7, false}, {3, 40, 4, true},  {3, 44, 1, false},
                             {3, 50, 1, true},  {4, 100, 1, true}, {4, 99, 2, false}, {3, 100, 1, false},
                             {1, 35, 1, true},  {1, 34, 1, false}, {1, 35, 2, false}, {2, 35, 1, false}};
    Devices devices(line());
    for (const auto& [function, start, count, exists] : kRows) {
        const wire::Pdu answer = ask(devices, {function, 0, start, 0, count});
        EXPECT_EQ(answer[0] == function, exists) << int{function} << ": " << int{start} << "+" << int{count};
        EXPECT_TRUE(exists || answer == (wire::Pdu{static_cast<std::uint8_t>(function | 0x80), 2}));
    }
}

TEST(Device, OffersWhatTheProjectLetsBeReadBetweenThem) {
    auto described = line();
    described.devices[0].gaps = model::Gaps::always;
    const auto answers = [&](std::initializer_list<std::uint8_t> pdu) {
        Devices devices(described);
        return ask(devices, pdu)[0] == 0x03;
    };
    EXPECT_TRUE(answers({0x03, 0, 10, 0, 34}));
    EXPECT_FALSE(answers({0x03, 0, 9, 0, 2})) << "nothing is before the first";
    described.devices[0].no_read[3] = {{20, 20}};
    EXPECT_FALSE(answers({0x03, 0, 10, 0, 34}));
    described.devices[0].no_read[3].clear();
    described.devices[0].readable[3] = {{0, 30}, {44, 60}};
    EXPECT_FALSE(answers({0x03, 0, 10, 0, 34}));
    EXPECT_TRUE(answers({0x03, 0, 40, 0, 11}));
}

TEST(Device, ValuesMoveAndAreTheSameInEveryRun) {
    Devices first(line()), second(line());
    std::set<double> seen;
    for (Duration t{}; t < 60s; t += 1s) {
        const double value = temperature(first, at(t));
        EXPECT_EQ(value, temperature(second, at(t)));
        EXPECT_TRUE(value > 5 && value < 120) << value;
        seen.insert(value);
    }
    EXPECT_GT(seen.size(), 20u);
    EXPECT_EQ(ask(first, {0x03, 0, 40, 0, 4}), (wire::Pdu{3, 8, 'L', 'a', 'b', 'e', 'l', 0, 0, 0}));
}

TEST(Device, WrittenVariablesStayTheOthersMove) {
    Devices devices(line());
    const wire::Pdu written{0x10, 0, 10, 0, 2, 4, 0x00, 0x00, 0x42, 0x28};  // 42.0, low register first
    serve::Context context;
    context.unit = UnitId{16};
    EXPECT_EQ(devices.handle(context, wire::RequestView(written.span())).pdu.size(), 5u);
    for (Duration t{}; t < 60s; t += 7s) EXPECT_EQ(temperature(devices, at(t)), 42.0);
    std::set<std::uint8_t> energy;
    for (Duration t{}; t < 60s; t += 7s) energy.insert(ask(devices, {0x03, 0, 12, 0, 4}, at(t))[3]);
    EXPECT_GT(energy.size(), 3u);
    EXPECT_EQ(ask(devices, {0x05, 0, 35, 0xFF, 0}), (wire::Pdu{0x05, 0, 35, 0xFF, 0}));
    for (Duration t{}; t < 60s; t += 1s)
        EXPECT_EQ(ask(devices, {0x01, 0, 35, 0, 1}, at(t)), (wire::Pdu{1, 1, 1}));
}

TEST(Device, Behaviours) {
    Devices devices(line());
    Device& device = devices[0];
    const wire::Pdu read{0x03, 0, 10, 0, 2};
    serve::Context context;
    context.unit = UnitId{16};
    EXPECT_EQ(devices.handle(context, wire::RequestView(read.span())).delay, 7ms)
        << "the project's turnaround";
    device.behaviour.refusals = {{Area::holding_register, {11, 11}, wire::ExceptionCode::server_device_busy}};
    EXPECT_EQ(devices.handle(context, wire::RequestView(read.span())).pdu, (wire::Pdu{0x83, 6}));
    EXPECT_EQ(ask(devices, {0x03, 0, 10, 0, 1})[0], 0x03);
    EXPECT_EQ(ask(devices, {0x04, 0, 100, 0, 1})[0], 0x04);
    device.behaviour.refuses_all = wire::ExceptionCode::server_device_failure;
    EXPECT_EQ(ask(devices, {0x04, 0, 100, 0, 1}), (wire::Pdu{0x84, 4}));
    device.behaviour.dead = true;
    EXPECT_EQ(devices.handle(context, wire::RequestView(read.span())).kind, serve::Answer::Kind::silence);
    device.behaviour = {};
    EXPECT_EQ(devices.handle(context, wire::RequestView(read.span())).delay, 0ms);
}

TEST(Device, ADeadOneDoesNotReceiveBroadcasts) {
    for (const bool dead : {false, true}) {
        Devices devices(line(), {.moving = false});
        devices[0].behaviour.dead = dead;
        serve::Context broadcast;
        broadcast.broadcast = true;
        const wire::Pdu write{0x06, 0, 12, 0x12, 0x34};
        EXPECT_EQ(devices.handle(broadcast, wire::RequestView(write.span())).kind,
                  serve::Answer::Kind::silence);
        devices[0].behaviour.dead = false;
        EXPECT_EQ(ask(devices, {0x03, 0, 12, 0, 1}),
                  dead ? (wire::Pdu{3, 2, 0, 0}) : (wire::Pdu{3, 2, 0x12, 0x34}));
    }
}

TEST(Device, BlankOnesHaveEverything) {
    Devices ramp(UnitId{1}, Fill::ramp);
    EXPECT_EQ(ask(ramp, {0x03, 0xFF, 0xFE, 0, 2}, {}, 1), (wire::Pdu{3, 4, 0xFF, 0xFE, 0xFF, 0xFF}));
    EXPECT_EQ(ask(ramp, {0x04, 0x00, 0x05, 0, 1}, {}, 1), (wire::Pdu{4, 2, 0, 5}));
    EXPECT_EQ(ask(ramp, {0x01, 0xFF, 0xF9, 0, 7}, {}, 1), (wire::Pdu{1, 1, 0b1010101}));
    EXPECT_EQ(ask(ramp, {0x02, 0x00, 0x00, 0, 8}, {}, 1), (wire::Pdu{2, 1, 0b10101010}));
    EXPECT_EQ(ask(ramp, {0x06, 0x00, 0x05, 9, 9}, {}, 1), (wire::Pdu{6, 0, 5, 9, 9}));
    EXPECT_EQ(ask(ramp, {0x03, 0x00, 0x05, 0, 1}, {}, 0), (wire::Pdu{3, 2, 9, 9}));
    Devices zero(UnitId{1}, Fill::zero);
    EXPECT_EQ(ask(zero, {0x03, 0x12, 0x34, 0, 1}, {}, 1), (wire::Pdu{3, 2, 0, 0}));
    Devices random(UnitId{1}, Fill::random), again(UnitId{1}, Fill::random);
    EXPECT_EQ(ask(random, {0x03, 0, 0, 0, 9}, {}, 1), ask(again, {0x03, 0, 0, 0, 9}, {}, 1));
    EXPECT_NE(ask(random, {0x03, 0, 0, 0, 9}, {}, 1), ask(zero, {0x03, 0, 0, 0, 9}, {}, 1));
}

TEST(Pattern, StaysWithinItsType) {
    constexpr DataType kTypes[] = {DataType::boolean, DataType::int16, DataType::uint16, DataType::int32,
                                   DataType::uint32,  DataType::int64, DataType::uint64, DataType::float32,
                                   DataType::float64, DataType::string};
    for (const DataType type : kTypes) {
        const Pattern pattern(type, "Some");
        value::Layout layout;
        layout.type = type;
        layout.registers = 2;
        for (Duration t{}; t < 24h * 400; t += 13h + 17s) {
            const auto encoded = value::encode(layout, pattern.at(at(t)));
            ASSERT_TRUE(encoded.has_value()) << name(type);
            EXPECT_FALSE(encoded->rounded) << name(type);
        }
    }
}

}  // namespace device_test
}  // namespace takt::sim
