// The values of the demo: in their ranges, slow where they are slow in a plant, and fitting together.
#include "online/demo_plant.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace takt::app {
namespace demo_plant_test {

using namespace std::chrono_literals;

const Instant kStart{1000s};
constexpr Duration kStep = 10s;

struct Limits {
    const char* name;
    double least;
    double greatest;
    double per_minute;  // the most that it changes
};
constexpr Limits kLimits[]{
    {"Supply temperature", 63, 67, 0.5},
    {"Return temperature", 45, 57, 1},
    {"Pressure", 1.7, 1.9, 0.04},
    {"Gas flow", 20, 60, 6},
    {"Setpoint", 65, 65, 0},
    {"Voltage L1", 227, 233, 2},
    {"Voltage L2", 227, 233, 2},
    {"Voltage L3", 227, 233, 2},
    {"Energy", 48'200, 48'220, 1},  // whole units
    {"Running", 1, 1, 0},
    {"Fault", 0, 0, 0},
    {"Speed", 1050, 1450, 40},
    {"Flow", 14, 24, 2},
    {"Delivery pressure", 0.8, 3, 0.2},
    {"Power", 0.5, 2.5, 0.2},
};

double value(const DemoPlant& plant, const char* name, Instant t) {
    return plant.value(name, t).value();
}

TEST(DemoPlant, EachValueIsInItsRangeAndAsSlowAsInAPlant) {
    const DemoPlant plant(kStart);
    for (const auto& its : kLimits)
        for (Instant t = kStart - 1h; t < kStart + 1h; t += kStep) {
            const double now = value(plant, its.name, t);
            ASSERT_GE(now, its.least) << its.name;
            ASSERT_LE(now, its.greatest) << its.name;
            ASSERT_LE(std::abs(value(plant, its.name, t + 1min) - now), its.per_minute) << its.name;
        }
}

TEST(DemoPlant, ThePumpFollowsItsCurve) {
    const DemoPlant plant(kStart);
    for (Instant t = kStart - 1h; t < kStart + 1h; t += kStep) {
        const auto its = plant.at(t);
        const double n = its.speed / 1450;
        ASSERT_NEAR(its.delivery, 3.2 * n * n - 0.0021 * its.flow * its.flow, 1e-9);
        // m³/h times bar is 1/36 kW.
        const double efficiency = its.flow * its.delivery / 36 / its.power;
        ASSERT_NEAR(efficiency, 0.62, 1e-9);
        ASSERT_NEAR(its.gas * 8.7, its.flow * (its.supply - its.back) * 1.163, 1e-9);
    }
}

TEST(DemoPlant, EqualTimesHaveEqualValuesAndTheCounterNeverFalls) {
    const DemoPlant plant(kStart);
    const DemoPlant other(kStart);
    double before = 0;
    for (Instant t = kStart - 1h; t < kStart + 1h; t += kStep) {
        EXPECT_EQ(plant.at(t).power, other.at(t).power);
        EXPECT_GE(plant.at(t).energy, before);
        before = plant.at(t).energy;
    }
}

TEST(DemoPlant, APumpThatIsSwitchedOffMovesNoWater) {
    DemoPlant plant(kStart);
    plant.on_written("Running", 0, kStart);
    EXPECT_GT(plant.at(kStart + 1s).flow, 1) << "it runs down";
    const auto stopped = plant.at(kStart + 1min);
    for (const double its : {stopped.speed, stopped.flow, stopped.delivery, stopped.power, stopped.gas})
        EXPECT_NEAR(its, 0, 0.01);
    plant.on_written("Running", 1, kStart + 1min);
    EXPECT_GT(plant.at(kStart + 2min).flow, 14);
}

TEST(DemoPlant, TheWaterFollowsTheSetpointSlowly) {
    DemoPlant plant(kStart);
    const double before = plant.at(kStart).supply;
    plant.on_written("Setpoint", 75, kStart);
    EXPECT_EQ(plant.at(kStart + 1s).setpoint, 75);
    EXPECT_NEAR(plant.at(kStart + 1s).supply, before, 0.2);
    EXPECT_NEAR(plant.at(kStart + 1h).supply, 75, 1);
}

TEST(DemoPlant, OtherVariablesKeepTheirPattern) {
    DemoPlant plant(kStart);
    plant.on_written("Speed", 1, kStart);
    EXPECT_EQ(plant.value("Bearing temperature", kStart), std::nullopt);
}

}  // namespace demo_plant_test
}  // namespace takt::app
