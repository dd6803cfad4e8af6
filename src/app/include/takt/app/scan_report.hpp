// What a scan found, told: as lines, as JSON, as a project.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/app/texts.hpp"
#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/line/target.hpp"
#include "takt/discover/line_scan.hpp"

namespace takt::app {

/// One device, and where it was found.
struct FoundDevice {
    line::Target target;
    discover::FoundUnit unit;
};

/// A place at which something was in the way.
struct ScanTrouble {
    enum class Kind : std::uint8_t {
        error,     ///< it could not be opened, or was lost: `error`
        garbled,   ///< answers of `unit` that never checked
        busy,      ///< others leave the line no silence
        strangers  ///< frames of units that were not asked
    };
    Kind kind = Kind::error;
    line::Target target;
    Error error;
    std::uint8_t unit = 0;
};

struct ScanFindings {
    std::vector<FoundDevice> devices;
    std::vector<ScanTrouble> troubles;
    std::uint64_t requests = 0;
    std::size_t absent_hosts = 0;  ///< of ranges: nobody there
    Duration duration{};
    bool complete = false;
};

/// "rtu:///dev/ttyUSB0?baud=9600&parity=none&stop_bits=1 --unit 16  12.3 ms  ACME T1 1.0", without line end.
[[nodiscard]] std::string device_line(const Texts& texts, const FoundDevice& device);

/// What it says it is, in a few words; empty: nothing.
[[nodiscard]] std::string identity_text(const discover::UnitIdentity& identity);

[[nodiscard]] std::string trouble_line(const Texts& texts, const ScanTrouble& trouble);

/// The object of docs/cli.md, `takt scan --json`.
[[nodiscard]] file::Json scan_json(const Texts& texts, const ScanFindings& findings);

/// A project with a line for each place and a device for each unit; settings of a port at which less was
/// found than at others stand in comments, since a port has one.
[[nodiscard]] std::string scan_project(const Texts& texts, const ScanFindings& findings);

}  // namespace takt::app
