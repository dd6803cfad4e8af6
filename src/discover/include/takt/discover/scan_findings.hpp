// What a scan of ports and hosts found.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/discover/line_scan.hpp"
#include "takt/model/line.hpp"

namespace takt::discover {

/// A unit that responded, and the line (without devices) on which it did.
struct FoundDevice {
    model::Line line;
    FoundUnit unit;
};

/// What kept a scan from finding units on a line.
struct ScanTrouble {
    enum class Kind : std::uint8_t {
        error,     ///< the line could not be opened, or its link was lost: `error`
        garbled,   ///< `unit` responded, but never with a frame that checks
        busy,      ///< other traffic leaves the line no silence
        strangers  ///< frames of units that were not asked: the line has another master
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
    bool complete = false;
};

}  // namespace takt::discover
