// The ports and hosts of a scan, and the settings it tries on each.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/bus/host_range.hpp"
#include "takt/bus/line_scan.hpp"
#include "takt/model/line.hpp"

namespace takt::bus {

/// The settings to try on serial ports. An empty list: those of the port's URL, else the usual ones.
struct SerialChoices {
    std::vector<std::uint32_t> bauds;
    std::vector<wire::Parity> parities;
    std::vector<std::uint32_t> stop_bits;
};

/// One port or host: a line without devices for each setting to try, the most likely one first. A host has
/// one.
struct ScanTarget {
    std::vector<model::Line> settings;
    bool of_range = false;  ///< a host of a range: a refused connection is no error

    [[nodiscard]] bool is_serial() const { return settings.front().transport == model::Transport::serial; }
};

/// The settings of a serial port, by how often lines are set like this.
/// @param port  the target of `url`
[[nodiscard]] ScanTarget serial_target(const model::Line& port, std::string_view url,
                                       const SerialChoices& choices);

/// The hosts of a range, each as `first` with its own address.
[[nodiscard]] std::vector<ScanTarget> host_targets(const model::Line& first, const HostRange& hosts);

/// Appends the targets that the list does not have yet.
/// @param name  what they were written as, for the error
/// @returns out_of_range (name, targets, 1, kMaxScanTargets)
[[nodiscard]] Result<void> add_targets(std::vector<ScanTarget>& targets, std::vector<ScanTarget> added,
                                       std::string_view name);

/// The requests to the units of every target.
struct ScanRequest {
    /// 0..255; on serial lines those of 1..247. Empty: 1..247, on hosts 1, 0, 255, 2..247: a host that is a
    /// device itself has one of the first three.
    std::vector<std::uint32_t> units;
    std::optional<Duration> wait;  ///< nothing: 100 ms on serial lines; elsewhere 1 s, ScanConfig::adaptive
    bool identify = true;
    bool thorough = false;
};

/// The configuration of the scan of one target; its `line` is set for each setting.
/// @returns out_of_range (the first unit, 1, 247) when a serial line has none of the units
[[nodiscard]] Result<ScanConfig> scan_config(const ScanRequest& request, const ScanTarget& target);

}  // namespace takt::bus
