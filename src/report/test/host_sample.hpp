// A configuration of a host and snapshots of it, made by hand: the fixtures of the reports of a running
// project.
#pragma once

#include <memory>
#include <string>

#include "sample.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/plan/plan.hpp"

namespace takt::report::test {

/// A text that must be escaped for a terminal, a line of text and JSON.
inline const std::string kHostile = "a\x1b[2J\nb\"\\\x07";
/// The same as a line of text shows it.
inline const std::string kHostileLine = R"(a\u{1B}[2J\nb"\\u{07})";

/// A boiler with a value of each kind: a register with a unit, a scaled one, a bit, a text; and a local.
inline const std::string kPlant = R"(takt: 1
lines:
  - name: main
    transport: serial
    port: /dev/ttyUSB0
    baud: 19200
    devices:
      - name: Котёл
        address: 16
        poll_period: 500ms
        turnaround: 5ms
        variables:
          - {name: Level, type: int16, register: 0, read: 0x03, write: 0x10, unit: мм}
          - {name: Speed, type: int16, register: 1, read: 0x03, write: 0x10, scale: 0.5}
          - {name: Pump, type: bool, coil: 3, read: 0x01, write: 0x05}
          - {name: Tag, type: string, length: 4, register: 10, read: 0x03, write: 0x10}
locals:
  - {name: go, type: bool}
)";

inline host::ConfigurationPtr configuration_of(model::Project project) {
    auto plan = plan::make_plan(project);
    return std::make_shared<const host::Configuration>(1, std::move(project), std::move(plan));
}

inline host::ConfigurationPtr plant() {
    static const auto kConfiguration = configuration_of(project_of(kPlant));
    return kConfiguration;
}

inline value::SlotId slot_of(const std::string& name) {
    const auto slot = plant()->find(name);
    EXPECT_TRUE(slot) << name;
    return slot.value_or(value::SlotId{});
}

/// A snapshot with every part of the right size, nothing measured, ten seconds after the start.
inline host::Snapshot snapshot_of(const host::ConfigurationPtr& configuration) {
    using namespace std::chrono_literals;
    host::Snapshot made;
    made.configuration = configuration;
    made.started = Instant{1s};
    made.t = Instant{11s};
    made.values.resize(configuration->slot_count());
    for (const auto& plan : configuration->plan().lines) {
        const auto& devices = configuration->project().lines[plan.line].devices;
        host::Snapshot::Line line;
        line.plan = std::make_shared<const plan::LinePlan>(plan);
        line.requests.resize(plan.requests.size());
        line.devices.resize(devices.size());
        line.times.resize(devices.size());
        for (const auto& device : devices)
            line.variables.resize(line.variables.size() + device.variables.size());
        made.lines.push_back(std::move(line));
    }
    return made;
}

}  // namespace takt::report::test
