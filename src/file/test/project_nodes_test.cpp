#include "takt/file/project_nodes.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <utility>

#include "takt/file/convert.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"

namespace takt::file {
namespace project_nodes_test {

using namespace std::chrono_literals;

model::Device found_device() {
    model::Device device;
    device.name = "no";  // a word with another meaning in YAML
    device.address = UnitId{7};
    device.poll_period = 250ms;
    device.response_timeout = 1500ms;
    device.comment = "AC\"ME";
    device.registers_per_request = 40;
    device.registers_per_request_set = true;
    device.fc23 = true;
    device.readable[static_cast<std::size_t>(wire::Area::coil)] = {{3, 3}};
    device.readable[static_cast<std::size_t>(wire::Area::holding_register)] = {{0, 99}, {200, 200}};
    device.variables = {{.name = "a",
                         .type = DataType::uint16,
                         .register_number = 5,
                         .read = wire::Function::read_holding_registers,
                         .period = 250ms},
                        {.name = "b",
                         .type = DataType::boolean,
                         .area = wire::Area::coil,
                         .register_number = 1,
                         .bit = 2,
                         .read = wire::Function::read_coils,
                         .write = wire::Function::write_single_coil,
                         .period = 1s}};
    return device;
}

constexpr const char* kProject = R"(takt: 1
lines:
  # the boiler
  # and its pump
  - name: l
    transport: serial
    port: /dev/ttyS1
    framing: rtu
    baud: 9600
    parity: even
    stop_bits: 1
    data_bits: 8
    devices:
      # left out: 3
      - name: "no"
        address: 7
        comment: "AC\"ME"
        poll_period: 250ms
        response_timeout: 1500ms
        fc23: true
        offers:
          coil: [3]
          holding_register: [0..99, 200]
        readable:
          coil: [3]
          holding_register: [0..99, 200]
        registers_per_request: 40
        group_requests: false
        variables:
          - {name: a, type: uint16, register: 5, read: 0x03}
          - {name: b, type: bool, coil: 18, read: 0x01, write: 0x05, period: 1s}
)";

TEST(ProjectNodes, AreWrittenAsAProjectFile) {
    model::Line line;
    line.name = "l";
    line.transport = model::Transport::serial;
    line.port = "/dev/ttyS1";
    line.format = {.baud = 9600, .data_bits = 8, .parity = wire::Parity::even, .stop_bits = 1};
    auto root = project_node({line_node(line)});
    auto& lines = root.entries.back().value.items;
    auto& devices = lines[0].entries.back().value.items;
    devices.push_back(device_node(found_device(), Ranges::all));
    EXPECT_EQ(write_project(root, {{&lines[0], "the boiler\nand its pump\n"}, {&devices[0], "left out: 3"}}),
              kProject);
    const auto read = model::interpret(load_text("p.yaml", kProject).document);
    ASSERT_FALSE(read.has_errors());
    const auto& device = read.project.lines.at(0).devices.at(0);
    EXPECT_EQ(device.readable, found_device().readable);
    EXPECT_EQ(device.variables.at(1).start(), 18);
}

TEST(ProjectNodes, DefaultsAreNotWritten) {
    const auto defaults = model::device_defaults(model::Profile::generic);
    model::Device device{.name = "d",
                         .poll_period = defaults.poll_period,
                         .response_timeout = defaults.response_timeout,
                         .group_requests = defaults.group_requests};
    EXPECT_EQ(write_device_keys(device_node(device, Ranges::read)), "name: d\naddress: 1\nvariables: []\n");
    EXPECT_EQ(write_device_keys(range_keys(device, Ranges::all)), "");
    device.readable[0] = {{0, 1}};
    EXPECT_EQ(write_device_keys(range_keys(device, Ranges::read)), "readable:\n  coil: [0..1]\n");
}

}  // namespace project_nodes_test
}  // namespace takt::file
