// The plant of `takt demo`: a boiler, a pump that moves its water, and the meter of the house.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/model/line.hpp"
#include "takt/sim/devices.hpp"
#include "takt/sim/value_source.hpp"

namespace takt::app {

/// A value on its way to another one, most of it within the time constant `tau`.
struct Approach {
    double from = 0;
    double to = 0;
    Instant begin{};
    double tau = 1;  ///< seconds, > 0

    [[nodiscard]] double at(Instant t) const;
    /// Goes to `target` from where it is at `t`.
    void turn(double target, Instant t);
};

/// All values at one instant, in the units of examples/demo.yaml. They fit together: the power of the pump
/// follows from its flow and pressure, the gas from the heat that the water takes.
struct PlantState {
    double supply, back, pressure, gas, setpoint;
    double voltage_1, voltage_2, voltage_3, energy;
    double running, fault, speed, flow, delivery, power;
};

/// Pure functions of time and of what was written. One owner, one thread.
class DemoPlant final : public sim::PlantModel {
public:
    /// Whether a line has all variables of the plant, as that of examples/demo.yaml.
    [[nodiscard]] static bool fits(const model::Line& line);

    /// @param start  the counters have their first values then; earlier times are the past of the plant
    explicit DemoPlant(Instant start);

    [[nodiscard]] PlantState at(Instant t) const;

    [[nodiscard]] std::optional<double> value(std::string_view variable, Instant t) const override;
    /// The setpoint, and whether the pump runs; others change nothing.
    void on_written(std::string_view variable, double value, Instant t) override;

    /// The devices show this plant, which must outlive them.
    void show(sim::Devices& devices);

private:
    Instant start_;
    Approach setpoint_;  // as the burner has reached it
    Approach turning_;   // part of the speed: 0 while the pump stands
};

/// Writes the hour before `now` to a new history: what a master would have read from the simulated devices of
/// the line at those instants. Variables that the plant does not have are left out.
/// @param plant  as it is now
/// @returns the errors of store::History
[[nodiscard]] Result<void> write_demo_past(const std::string& database, const model::Line& line,
                                           DemoPlant& plant, Instant now);

}  // namespace takt::app
