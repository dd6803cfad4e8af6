#include "online/demo_plant.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace takt::app {
namespace {

constexpr double kSetpoint = 65;          // °C
constexpr double kBurnerSeconds = 240;    // the water follows the setpoint
constexpr double kRunUpSeconds = 3;       // of the pump
constexpr double kRatedSpeed = 1450;      // 1/min
constexpr double kRatedFlow = 24;         // m³/h
constexpr double kShutOffPressure = 3.2;  // bar, at rated speed without flow
constexpr double kCurve = 0.0021;         // bar/(m³/h)²
constexpr double kPumpEfficiency = 0.62;
constexpr double kHousePower = 6.2;      // kW, mean
constexpr double kFirstEnergy = 48'210;  // kWh
constexpr double kHeatOfWater = 1.163;   // kWh/(m³·K)
constexpr double kHeatOfGas = 8.7;       // kWh/m³, with the losses of the boiler

double seconds(Duration its) {
    return std::chrono::duration<double>(its).count();
}

/// Between -1 and 1.
double wave(double t, double period, double phase = 0) {
    return std::sin(2 * std::numbers::pi * (t / period + phase));
}

struct Named {
    std::string_view name;
    double PlantState::* value;
    double resolution;  // of the sensor
};
constexpr std::array kNames{Named{"Supply temperature", &PlantState::supply, 0.1},
                            Named{"Return temperature", &PlantState::back, 0.1},
                            Named{"Pressure", &PlantState::pressure, 0.01},
                            Named{"Gas flow", &PlantState::gas, 0.1},
                            Named{"Setpoint", &PlantState::setpoint, 0.1},
                            Named{"Voltage L1", &PlantState::voltage_1, 0.1},
                            Named{"Voltage L2", &PlantState::voltage_2, 0.1},
                            Named{"Voltage L3", &PlantState::voltage_3, 0.1},
                            Named{"Energy", &PlantState::energy, 1},
                            Named{"Running", &PlantState::running, 1},
                            Named{"Fault", &PlantState::fault, 1},
                            Named{"Speed", &PlantState::speed, 1},
                            Named{"Flow", &PlantState::flow, 0.1},
                            Named{"Delivery pressure", &PlantState::delivery, 0.01},
                            Named{"Power", &PlantState::power, 0.01}};

}  // namespace

double Approach::at(Instant t) const {
    return t <= begin ? from : to + (from - to) * std::exp(-seconds(t - begin) / tau);
}

void Approach::turn(double target, Instant t) {
    from = at(t);
    to = target;
    begin = t;
}

DemoPlant::DemoPlant(Instant start)
    : start_(start),
      setpoint_{kSetpoint, kSetpoint, start, kBurnerSeconds},
      turning_{1, 1, start, kRunUpSeconds} {}

bool DemoPlant::fits(const model::Line& line) {
    return std::ranges::all_of(kNames, [&](const Named& its) {
        return std::ranges::any_of(line.devices, [&](const model::Device& device) {
            return std::ranges::find(device.variables, its.name, &model::Variable::name) !=
                   device.variables.end();
        });
    });
}

void DemoPlant::show(sim::Devices& devices) {
    for (std::size_t i = 0; i < devices.size(); ++i) devices[i].set_model(this);
}

// A pump at n times its rated speed: the flow follows n, the pressure n² less what the flow loses.
PlantState DemoPlant::at(Instant t) const {
    const double s = seconds(t - start_);
    const double demand = 0.5 + 0.35 * wave(s, 3000) + 0.1 * wave(s, 700, 0.2);  // 0.05..0.95
    PlantState its{};
    its.setpoint = setpoint_.to;
    its.running = turning_.to;
    const double n = turning_.at(t) * (0.74 + 0.24 * demand);
    its.speed = kRatedSpeed * n;
    its.flow = kRatedFlow * n * (0.88 + 0.06 * wave(s, 500));
    its.delivery = kShutOffPressure * n * n - kCurve * its.flow * its.flow;
    its.power = its.flow * its.delivery / 36 / kPumpEfficiency;
    its.supply = setpoint_.at(t) + 0.5 * wave(s, 900);
    its.back = its.supply - 11 - 5 * demand;
    its.pressure = 1.8 + 0.006 * (its.supply - kSetpoint) + 0.02 * wave(s, 240);
    its.gas = its.flow * (its.supply - its.back) * kHeatOfWater / kHeatOfGas;
    const auto volts = [s](double phase) {
        return 230 + 2.1 * wave(s, 1300, phase) + 0.5 * wave(s, 47, phase);
    };
    its.voltage_1 = volts(0);
    its.voltage_2 = volts(0.31);
    its.voltage_3 = volts(0.67);
    its.energy = kFirstEnergy + kHousePower * s / 3600;
    return its;
}

std::optional<double> DemoPlant::value(std::string_view variable, Instant t) const {
    for (const auto& its : kNames)
        if (its.name == variable) return std::round(at(t).*its.value / its.resolution) * its.resolution;
    return std::nullopt;
}

void DemoPlant::on_written(std::string_view variable, double value, Instant t) {
    if (variable == "Setpoint") setpoint_.turn(value, t);
    if (variable == "Running") turning_.turn(value, t);
}

}  // namespace takt::app
