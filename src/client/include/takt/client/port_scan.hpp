// Scans of real ports and hosts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "takt/bus/target_scan.hpp"
#include "takt/client/connection.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/traffic_factory.hpp"

namespace takt::client {

/// The ports and hosts that URLs name, each once. A URL may name a range of hosts.
/// @returns what line::parse_target() and the parsers of bus_discover return
[[nodiscard]] Result<std::vector<bus::ScanTarget>> scan_targets(std::span<const std::string> urls,
                                                                const bus::SerialChoices& choices);

/// Opens the line of each setting of a target and runs a bus::TargetScan on it. The loop's thread only.
class PortScan {
public:
    struct Options {
        bus::TargetScan::Options scan;  ///< on_setting_finished is replaced
        line::TrafficFactory traffic;   ///< may be empty
        std::function<void()> on_end;   ///< the last call; must not destroy the scan
        OpenLine open = line::open_line;
    };

    /// @param loop, observer  must outlive the scan
    PortScan(line::Loop& loop, bus::ScanTarget target, Options options, bus::ScanObserver& observer);

    void begin();
    [[nodiscard]] bool running() const { return begun_ && !scan_.ended(); }
    [[nodiscard]] bool begun() const { return begun_; }
    [[nodiscard]] const bus::TargetScan& scan() const { return scan_; }

private:
    void next_setting();
    [[nodiscard]] bool open_setting();

    line::Loop& loop_;
    Options options_;
    bool begun_ = false;
    std::shared_ptr<wire::TrafficObserver> traffic_;
    bus::TargetScan scan_;
    std::unique_ptr<line::Driver> driver_;
    line::Timer step_;
};

/// Scans of many targets, at most kSideBySide at a time. The loop's thread only.
class PortScans {
public:
    static constexpr std::size_t kSideBySide = 32;

    /// @param loop, observer  must outlive the scans
    PortScans(line::Loop& loop, bus::ScanObserver& observer) : loop_(loop), observer_(observer) {}

    /// `options.on_end` is replaced.
    void add(bus::ScanTarget target, PortScan::Options options);
    /// After the last add().
    void begin() { begin_more(); }
    [[nodiscard]] bool ended() const { return running_ == 0; }

    /// The first scan that runs; nullptr: none.
    [[nodiscard]] const bus::TargetScan* current() const;

    /// Over all targets: units asked, units to ask, requests sent, and whether one could be reached.
    struct Totals {
        std::size_t done = 0;
        std::size_t total = 0;
        std::uint64_t requests = 0;
        bool reached = false;
    };
    [[nodiscard]] Totals totals() const;

private:
    void begin_more();

    line::Loop& loop_;
    bus::ScanObserver& observer_;
    std::vector<std::unique_ptr<PortScan>> scans_;
    std::size_t running_ = 0;
};

}  // namespace takt::client
