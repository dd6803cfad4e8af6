// The result of a scan: as lines of text, as JSON, as a project file.
#pragma once

#include <string>
#include <vector>

#include "takt/bus/found_project.hpp"
#include "takt/bus/target_scan.hpp"
#include "takt/file/json.hpp"
#include "takt/model/document.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// "rtu:///dev/ttyUSB0?baud=9600&parity=none&stop_bits=1 --unit 16  12.3 ms  ACME T1 1.0", without line end.
[[nodiscard]] std::string device_line(const Texts& texts, const bus::FoundDevice& device);

/// Vendor, product and revision in a few words, else the name in the answer to function 17; empty where the
/// unit identifies itself by neither.
[[nodiscard]] std::string identity_text(const bus::UnitIdentity& identity);

[[nodiscard]] std::string trouble_line(const Texts& texts, const bus::ScanTrouble& trouble);

/// The object that `takt scan --json` prints (docs/commands/scan.md).
[[nodiscard]] file::Json scan_json(const Texts& texts, const bus::ScanFindings& findings);

/// The nodes of a project file for what was found.
struct FoundNodes {
    bus::FoundProject project;
    /// Of each line of it, with its devices as the last entry.
    std::vector<model::Node> lines;
};
[[nodiscard]] FoundNodes found_nodes(const bus::ScanFindings& findings, const bus::DeviceProbes& probes);

/// A project with a line for each target and a device for each unit, with the ranges and the longest read of
/// those that were probed. A port has one line: devices found on it with other settings than most of its
/// devices are listed in comments, and so are units 0 and 255 of a host that is in the project by another
/// unit.
[[nodiscard]] std::string scan_project(const Texts& texts, const bus::ScanFindings& findings,
                                       const bus::DeviceProbes& probes = {});

/// The number of devices and requests and the time; absent hosts and an interruption where there are any.
[[nodiscard]] std::string scan_summary(const Texts& texts, const bus::ScanFindings& findings);

/// The line that is being scanned, its setting, and the number of devices found so far.
[[nodiscard]] std::string scan_progress(const Texts& texts, const bus::TargetScan& scan,
                                        const bus::ScanFindings& findings);

}  // namespace takt::report
