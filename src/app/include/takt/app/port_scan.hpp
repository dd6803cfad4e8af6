// A scan on a real port or host.
#pragma once

#include <functional>
#include <memory>

#include "takt/app/traffic_log.hpp"
#include "takt/discover/target_scan.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"

namespace takt::app {

/// Opens the line of each setting of a target and runs a discover::TargetScan on it. The loop's thread only.
class PortScan {
public:
    struct Options {
        discover::TargetScan::Options scan;
        TrafficLog* log = nullptr;
        std::function<void()> on_end;  ///< the last call; must not destroy the scan
    };

    /// @param loop, observer  must outlive the scan
    PortScan(line::Loop& loop, discover::ScanTarget target, Options options,
             discover::ScanObserver& observer);

    void begin();
    [[nodiscard]] bool running() const { return begun_ && !scan_.ended(); }
    [[nodiscard]] bool begun() const { return begun_; }
    [[nodiscard]] const discover::TargetScan& scan() const { return scan_; }

private:
    void next_setting();
    [[nodiscard]] bool open_setting();

    line::Loop& loop_;
    Options options_;
    bool begun_ = false;
    std::unique_ptr<LineTraffic> traffic_;
    discover::TargetScan scan_;
    std::unique_ptr<line::Driver> driver_;
    line::Timer step_;
};

}  // namespace takt::app
