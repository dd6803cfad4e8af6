// The findings of a scan of ports and hosts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/bus/line_scan.hpp"
#include "takt/model/line.hpp"

namespace takt::bus {

/// A unit that responded, and the line (without devices) on which it did.
struct FoundDevice {
    model::Line line;
    FoundUnit unit;
};

/// The reason why a scan could not find units on a line.
struct ScanTrouble {
    enum class Kind : std::uint8_t {
        error,          ///< the line could not be opened, or its link was lost: `error`
        garbled,        ///< `unit` responded, but never with a frame that checks; cut short: `error`
        busy,           ///< other traffic leaves the line no silence
        foreign_master  ///< frames of units outside the scan: the line has another master
    };
    Kind kind = Kind::error;
    model::Line line;
    Error error;
    std::uint8_t unit = 0;
};

struct ScanFindings {
    std::vector<FoundDevice> devices;
    std::vector<ScanTrouble> troubles;
    std::uint64_t requests = 0;
    std::size_t absent_hosts = 0;  ///< hosts of a range that accept no connection
    Duration duration{};
    bool reached = false;   ///< at least one line was opened, or one host accepted a connection
    bool complete = false;  ///< the scan was not interrupted
};

/// The error proves nothing about other settings of the same port, as a bit rate that the port does not have.
[[nodiscard]] bool is_of_setting(const Error& error);

/// The first error that kept a target from being scanned; nullptr: there is none.
[[nodiscard]] const Error* first_failure(const ScanFindings& findings);

enum class ScanOutcome : std::uint8_t {
    found,    ///< devices, and no target failed
    nothing,  ///< no device, and no target failed
    partly,   ///< interrupted, or some targets failed
    failed,   ///< no target could be reached: first_failure()
};
[[nodiscard]] ScanOutcome outcome_of(const ScanFindings& findings);

}  // namespace takt::bus
