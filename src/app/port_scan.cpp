#include "takt/app/port_scan.hpp"

#include <algorithm>
#include <utility>

#include "takt/app/client.hpp"

namespace takt::app {
namespace {

constexpr Duration kLeastConnectLimit = std::chrono::seconds(1);

}  // namespace

// The driver may not be destroyed from within its own call, so the next setting begins from the timer.
PortScan::PortScan(line::Loop& loop, discover::ScanTarget target, Options options,
                   discover::ScanObserver& observer)
    : loop_(loop),
      options_(std::move(options)),
      scan_(std::move(target),
            {options_.scan.scan, options_.scan.first_only, [this] { step_.set(line::now()); }}, observer),
      step_(loop, [this](Instant) { next_setting(); }) {}

void PortScan::begin() {
    begun_ = true;
    step_.set(line::now());
}

void PortScan::next_setting() {
    driver_.reset();
    scan_.end_setting();
    while (!scan_.ended())
        if (open_setting()) return;
    options_.on_end();
}

bool PortScan::open_setting() {
    const auto& line = scan_.line();
    if (options_.log)
        traffic_ = std::make_unique<LineTraffic>(*options_.log, line, LineTraffic::Side::master);
    scan_.begin_setting(one_off_line(line), traffic_.get());
    line::DriverOptions driving;
    driving.connect_limit = std::max(options_.scan.scan.wait, kLeastConnectLimit);
    driving.must_reconnect = [this] { return scan_.must_reconnect(); };
    driving.on_link = [this](Instant, bool up, const std::optional<Error>& why) {
        scan_.on_driver_link(up, why);
    };
    auto driver = line::open_line(loop_, line, scan_, driving);
    if (!driver) {
        scan_.on_open_failed(driver.error());
        return false;
    }
    driver_ = *std::move(driver);
    return true;
}

}  // namespace takt::app
