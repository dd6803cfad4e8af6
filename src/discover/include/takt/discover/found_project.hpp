// The project that a scan's findings make.
#pragma once

#include <vector>

#include "takt/discover/scan_findings.hpp"
#include "takt/model/line.hpp"

namespace takt::discover {

/// A line of the project; `line.devices[i]` is the device that `found[i]` is about.
struct FoundLine {
    model::Line line;
    std::vector<const FoundDevice*> found;
};

struct FoundProject {
    std::vector<FoundLine> lines;
    /// Devices on serial ports that already have a line with other settings: a port has one line.
    std::vector<const FoundDevice*> others;
};

/// A line for each port and host, those with the most devices first, named "line 1", "line 2", …, and a
/// device for each unit: its name, its address, a response time-out of three times its response time where
/// the default is too short, and one variable where it answered a read of item 0 with a value. A port on
/// which devices were found with several settings gets the settings of most of them.
/// @param findings  must outlive the result
[[nodiscard]] FoundProject found_project(const ScanFindings& findings);

}  // namespace takt::discover
