// The nodes of lines and devices that a program has found: what a project file says of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "takt/model/document.hpp"
#include "takt/model/line.hpp"

namespace takt::file {

/// The document of a project with these lines.
[[nodiscard]] model::Node project_node(std::vector<model::Node> lines);

/// How much is known of the ranges that a device has (Device::readable).
enum class Ranges : std::uint8_t {
    read,  ///< some of those that it has: `readable`
    all,   ///< it has no others: `offers`, too
};

/// Name, connection and `devices`, which is empty.
[[nodiscard]] model::Node line_node(const model::Line& line);

/// Name, address, and the keys that differ from the defaults of the profile generic, with the variables.
[[nodiscard]] model::Node device_node(const model::Device& device, Ranges ranges);

/// Of these keys: ranges, limit of registers and grouping.
[[nodiscard]] model::Node range_keys(const model::Device& device, Ranges ranges);

/// "5", "0..99"
[[nodiscard]] std::string range_text(const model::ItemRange& range);

}  // namespace takt::file
