// A project with the devices of a field and an MQTT output.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace takt::bench {

inline constexpr const char* kOutputName = "cloud";

struct PlantProject {
    std::size_t devices = 500;
    std::size_t variables = 10;  ///< of each device, in one request each second; all change with each read
    std::uint16_t field_port = 0;
    std::uint16_t broker_port = 0;
};

/// The journal of the output is in `<path without .yaml>.journal/<kOutputName>`.
void write_project(const std::string& path, const PlantProject& project);

}  // namespace takt::bench
