// The project that a scan's findings make.
#pragma once

#include <map>
#include <vector>

#include "takt/bus/device_probe.hpp"
#include "takt/bus/scan_findings.hpp"
#include "takt/model/line.hpp"

namespace takt::bus {

/// A line of the project; `line.devices[i]` is the device that `found[i]` is about.
struct FoundLine {
    model::Line line;
    std::vector<const FoundDevice*> found;
};

/// The registers of devices among the findings.
using DeviceProbes = std::map<const FoundDevice*, ProbeFindings>;

struct FoundProject {
    std::vector<FoundLine> lines;
    /// Units 0 and 255 of hosts where another unit identifies itself alike: the host itself has them too.
    std::vector<const FoundDevice*> same;
    /// Devices on serial ports that already have a line with other settings: a port has one line.
    std::vector<const FoundDevice*> others;
};

/// A line for each port and host, those with the most devices first, named "line 1", "line 2", …, and a
/// device for each unit: its name, its address, a response time-out of three times its response time where
/// the default is too short, and one variable where it answered a read of item 0 with a value. A probed
/// device has variables for the first kMostFoundVariables of its items instead. A port on which devices were
/// found with several settings gets the settings of most of them.
/// @param findings  must outlive the result
[[nodiscard]] FoundProject found_project(const ScanFindings& findings, const DeviceProbes& probes = {});

inline constexpr std::size_t kMostFoundVariables = 64;

/// Sets what the probe found: the ranges (`readable`), the longest read of registers, and whether requests
/// can be grouped.
void set_ranges(model::Device& device, const ProbeFindings& probe);

}  // namespace takt::bus
