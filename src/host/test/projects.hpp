// The project files of this module's tests, put together from lines, devices and variables.
#pragma once

#include <string>

namespace takt::host::test {

/// A variable in holding registers, read with function 3. @param more  further keys: ", write: 0x10"
[[nodiscard]] std::string variable_of(const std::string& name, int reg, const std::string& more = "");

/// A device that is polled each 100 ms. @param more  further keys, each ", key: value"
[[nodiscard]] std::string device_of(const std::string& name, int address, const std::string& variables,
                                    const std::string& more = "");

/// A simulated line. @param framing  "rtu" or "tcp"
[[nodiscard]] std::string line_of(const std::string& name, const std::string& devices,
                                  const std::string& framing = "rtu");

/// @param locals   "- {name: go, type: bool}", each on a line of its own; may be empty
/// @param servers  as in a project file, not indented; may be empty
[[nodiscard]] std::string project_with(const std::string& lines, const std::string& locals = "",
                                       const std::string& servers = "");

inline const std::string kOnChange = ", write: 0x10, write_on_change: true";

/// Level (read) and Setpoint (written on change), at address 1.
[[nodiscard]] std::string boiler(const std::string& further_variables = "");
/// Speed (read), at address 2.
[[nodiscard]] std::string pump(const std::string& of_speed = "");

}  // namespace takt::host::test
