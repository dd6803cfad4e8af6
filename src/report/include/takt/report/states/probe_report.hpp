// The result of a probe of a device: as text, JSON, and keys of a project file.
#pragma once

#include <cstdint>
#include <string>

#include "takt/bus/device_probe.hpp"
#include "takt/file/json.hpp"
#include "takt/model/document.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// The probe itself, for its reports.
struct ProbeRun {
    std::string target;
    std::uint8_t unit = 1;
    std::uint64_t transmissions = 0;  ///< requests sent, repetitions included
    Duration duration{};
    bool interrupted = false;
};

/// The request that is next: "holding_register 512".
[[nodiscard]] std::string probe_progress(const bus::ProbeProgress& progress);

/// A line for each readable range, "holding_register 0..99", and for each range of items that exist but
/// refuse, "holding_register 300 exception 4".
[[nodiscard]] std::string probe_text(const bus::ProbeFindings& findings);

/// The keys of a device in a project file: `offers`, `readable`, and as `registers_per_request` the longest
/// read of registers that the device accepted (`group_requests: false` where that is one); empty where
/// nothing is readable.
[[nodiscard]] model::Node probe_keys(const bus::ProbeFindings& findings);
[[nodiscard]] std::string probe_yaml(const bus::ProbeFindings& findings);

/// The object that `takt probe --json` prints (docs/commands/probe.md).
[[nodiscard]] file::Json probe_json(const bus::ProbeFindings& findings, const ProbeRun& run);

/// For each area the addresses that were tested, items that refuse, and a limit of its reads; at the end a
/// line with the number of requests and the time.
[[nodiscard]] std::string probe_summary(const Texts& texts, const bus::ProbeFindings& findings,
                                        const ProbeRun& run);

}  // namespace takt::report
