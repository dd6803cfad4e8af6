// Specs from a project and from options.
#include "takt/endpoint/spec.hpp"

#include <gtest/gtest.h>

#include "support.hpp"

namespace takt::endpoint {
namespace spec_test {

using namespace std::chrono_literals;
using wire::Area;

constexpr const char* kPlant = R"(
takt: 1
lines:
  - name: bus
    port: /dev/ttyS7
    baud: 9600
    parity: none
    devices:
      - name: Pump
        address: 5
        variables:
          - {name: Speed, type: int16, register: 0, read: 0x03, period: 1s}
servers:
  - name: gate/1
    listen: "*"
    tcp_port: 1502
    audit: audit.log
    max_connections: 7
    idle_timeout: 5s
    access:
      - {rule: read_only}
    relay:
      - {line: bus, units: [5], map: [{from: 9, to: 5}]}
    units:
      - address: 2
        banks:
          - {area: holding_register, items: [0..9], retain: [2..4]}
        durability: 100ms
        variables:
          - {name: Shown, type: int16, area: holding_register, register: 0, source: {variable: Speed}}
  - name: panel
    transport: serial
    port: /dev/ttyS8
    baud: 19200
    strict: true
    turnaround: 20ms
    frame_timeout: 3s
    units:
      - address: 1
        banks:
          - {area: coil, items: [0..7]}
)";

TEST(Spec, OfAProjectsServers) {
    const auto plant = test::project(kPlant);
    const auto specs = server_endpoints(plant, "/plants/plant.yaml", {}, true);
    ASSERT_EQ(specs.size(), 2u);
    const EndpointSpec& gate = specs[0];
    EXPECT_EQ(gate.name, "gate/1");
    ASSERT_EQ(gate.listeners.size(), 1u);
    ASSERT_TRUE(gate.listeners[0].address);
    EXPECT_EQ(gate.listeners[0].address->host, "") << "all addresses";
    EXPECT_EQ(gate.listeners[0].address->port, 1502);
    EXPECT_EQ(gate.listeners[0].limits.max_connections, 7u);
    EXPECT_EQ(gate.listeners[0].limits.idle_timeout, 5s);
    EXPECT_EQ(gate.audit, "/plants/audit.log");
    EXPECT_EQ(gate.access.size(), 1u);
    EXPECT_FALSE(gate.access_is_override);
    EXPECT_EQ(gate.relays.size(), 1u);
    EXPECT_EQ(std::get<ServerUnits>(gate.units).units.size(), 1u);
    ASSERT_EQ(gate.retained.size(), 1u);
    EXPECT_EQ(gate.retained[0].unit, 0u);
    EXPECT_EQ(gate.retained[0].path, "/plants/plant.gate_1-2.registers");
    EXPECT_EQ(gate.retained[0].durability, store::Durability::interval);
    const auto& kept = gate.retained[0].items[static_cast<std::size_t>(Area::holding_register)];
    EXPECT_EQ(kept, (std::vector<serve::AddressRange>{{2, 4}}));
    EXPECT_EQ(bound_to_lines(plant), 1u);

    const EndpointSpec& panel = specs[1];
    EXPECT_FALSE(panel.listeners[0].address);
    EXPECT_EQ(panel.listeners[0].line.port, "/dev/ttyS8");
    EXPECT_EQ(panel.listeners[0].line.format.baud, 19200u);
    EXPECT_TRUE(panel.listeners[0].strict);
    EXPECT_EQ(panel.listeners[0].turnaround, Duration(20ms));
    EXPECT_EQ(panel.listeners[0].frame_timeout, Duration(3s));
    EXPECT_EQ(panel.listeners[0].byte_timeout, Duration::zero()) << "the default";
    EXPECT_TRUE(panel.retained.empty());
}

TEST(Spec, OverridesCountInsteadOfTheProject) {
    const auto plant = test::project(kPlant);
    Overrides overrides;
    overrides.strict = true;
    overrides.limits.max_connections = 3;
    overrides.limits.byte_timeout = Duration(40ms);
    overrides.access.emplace();
    overrides.audit = "all.log";
    const auto specs = server_endpoints(plant, "plant.yaml", overrides, false);
    EXPECT_TRUE(specs[0].relays.empty()) << "the lines are not open here";
    EXPECT_TRUE(specs[0].access.empty());
    EXPECT_TRUE(specs[0].access_is_override);
    EXPECT_EQ(specs[0].audit, "all.log");
    EXPECT_EQ(specs[1].audit, "all.log");
    EXPECT_TRUE(specs[0].listeners[0].strict);
    EXPECT_EQ(specs[0].listeners[0].limits.max_connections, 3u);
    EXPECT_EQ(specs[0].listeners[0].limits.idle_timeout, 5s) << "what is not overridden stays";
    EXPECT_EQ(specs[1].listeners[0].byte_timeout, Duration(40ms));
    EXPECT_EQ(specs[1].listeners[0].frame_timeout, Duration(3s)) << "what is not overridden stays";
}

TEST(Spec, OfAProjectsDevices) {
    const auto plant = test::project(kPlant);
    const auto own = device_endpoints(plant, {});
    ASSERT_TRUE(own);
    EXPECT_EQ(own->at(0).name, "bus");
    EXPECT_EQ(own->at(0).listeners[0].line.port, "/dev/ttyS7");
    EXPECT_EQ(std::get<LineDevices>(own->at(0).units).line.devices.size(), 1u);

    const auto tcp = device_endpoints(plant, {.listen = "127.0.0.1:1502"});
    ASSERT_TRUE(tcp);
    const auto& listener = tcp->at(0).listeners[0];
    EXPECT_EQ(listener.address->port, 1502);
    EXPECT_EQ(listener.line.framing, wire::Framing::tcp) << "a serial line becomes Modbus TCP";
    EXPECT_EQ(listener.line.devices.size(), 1u) << "for their names";

    const auto serial = device_endpoints(plant, {.port = "rtu:///dev/ttyS9?baud=4800"});
    ASSERT_TRUE(serial);
    EXPECT_EQ(serial->at(0).listeners[0].line.port, "/dev/ttyS9");
    EXPECT_EQ(serial->at(0).listeners[0].line.format.baud, 4800u);
    EXPECT_EQ(serial->at(0).listeners[0].line.name, "bus");
}

TEST(Spec, PortsThatCannotBeAreErrors) {
    auto plant = test::project(kPlant);
    EXPECT_EQ(device_endpoints(plant, {.listen = "1:2:3"}).error().code, Code::syntax);
    EXPECT_EQ(device_endpoints(plant, {.port = "tcp://127.0.0.1"}).error().code, Code::unsupported);
    plant.lines[0].transport = model::Transport::simulated;
    EXPECT_EQ(device_endpoints(plant, {}).error().subject.view(), "bus: simulated");
    EXPECT_EQ(blank_endpoint({}, {.port = "bus://1"}).error().code, Code::syntax);
}

TEST(Spec, OfTheBlankDevice) {
    const auto spec =
        blank_endpoint(UnitId{3}, {.listen = ":1502", .port = "/dev/ttyS0", .fill = sim::Fill::ramp});
    ASSERT_TRUE(spec);
    ASSERT_EQ(spec->listeners.size(), 2u) << "the same unit on both";
    EXPECT_TRUE(spec->listeners[0].address);
    EXPECT_FALSE(spec->listeners[1].address);
    EXPECT_TRUE(spec->retained.empty());
    const auto& [units, fill] = std::get<ServerUnits>(spec->units);
    EXPECT_EQ(units.at(0).address, UnitId{3});
    EXPECT_EQ(fill, sim::Fill::ramp);
}

TEST(Spec, LimitsThatAreNotGivenStay) {
    model::ListenLimits limits;
    limits.max_per_peer = 3;
    const auto same = LimitOverrides{}.instead_of(limits);
    EXPECT_EQ(same.max_per_peer, 3u);
    LimitOverrides overrides;
    overrides.frame_timeout = Duration(1s);
    EXPECT_EQ(overrides.instead_of(limits).frame_timeout, Duration(1s));
    EXPECT_EQ(overrides.instead_of(limits).max_per_peer, 3u);
}

}  // namespace spec_test
}  // namespace takt::endpoint
