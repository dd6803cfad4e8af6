#include "projects.hpp"

#include <fmt/format.h>

namespace takt::host::test {

std::string variable_of(const std::string& name, int reg, const std::string& more) {
    return fmt::format("          - {{name: {}, type: int, register: {}, read: 0x03{}}}\n", name, reg, more);
}

std::string device_of(const std::string& name, int address, const std::string& variables,
                      const std::string& more) {
    std::string keys;
    for (const char c : more) keys += c == ',' ? std::string("\n       ") : std::string(1, c);
    return fmt::format(
        "      - name: {}\n        address: {}\n        poll_period: 100ms\n        turnaround: 5ms{}\n"
        "        variables:\n{}",
        name, address, keys, variables);
}

std::string line_of(const std::string& name, const std::string& devices, const std::string& framing) {
    return fmt::format("  - name: {}\n    transport: simulated\n    framing: {}\n{}    devices:\n{}", name,
                       framing, framing == "rtu" ? "    baud: 19200\n" : "", devices);
}

std::string project_with(const std::string& lines, const std::string& locals, const std::string& servers) {
    return "takt: 1\nlines:\n" + lines + (locals.empty() ? "" : "locals:\n" + locals) +
           (servers.empty() ? "" : "servers:\n" + servers);
}

std::string boiler(const std::string& further_variables) {
    return device_of("Boiler", 1,
                     variable_of("Level", 0) + variable_of("Setpoint", 10, kOnChange) + further_variables);
}

std::string pump(const std::string& of_speed) {
    return device_of("Pump", 2, variable_of("Speed", 0, of_speed), ", response_timeout: 50ms");
}

}  // namespace takt::host::test
