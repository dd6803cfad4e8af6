#include "takt/client/port_scan.hpp"

#include <algorithm>
#include <utility>

#include "takt/client/connection.hpp"
#include "takt/line/target.hpp"

namespace takt::client {
namespace {

using bus::ScanTarget;

constexpr Duration kLeastConnectLimit = std::chrono::seconds(1);

Result<std::vector<ScanTarget>> targets_of(const std::string& url, const bus::SerialChoices& choices) {
    TAKT_TRY(const auto range, bus::parse_url_range(url));
    TAKT_TRY(const auto target, line::parse_target(range ? range->first_url : url));
    const auto line = target.as_line();
    if (range) return bus::host_targets(line, range->hosts);
    if (line.transport == model::Transport::serial)
        return std::vector<ScanTarget>{bus::serial_target(line, url, choices)};
    return std::vector<ScanTarget>{{{line}, false}};
}

}  // namespace

Result<std::vector<ScanTarget>> scan_targets(std::span<const std::string> urls,
                                             const bus::SerialChoices& choices) {
    std::vector<ScanTarget> targets;
    for (const auto& url : urls) {
        TAKT_TRY(auto named, targets_of(url, choices));
        TAKT_CHECK(bus::add_targets(targets, std::move(named), url));
    }
    return targets;
}

// The driver may not be destroyed from within its own call, so the next setting begins from the timer.
PortScan::PortScan(line::Loop& loop, ScanTarget target, Options options, bus::ScanObserver& observer)
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
    if (options_.traffic) traffic_ = options_.traffic(line);
    scan_.begin_setting(one_off_line(line), traffic_.get());
    line::DriverOptions driving;
    driving.connect_limit = std::max(options_.scan.scan.wait, kLeastConnectLimit);
    driving.must_reconnect = [this] { return scan_.must_reconnect(); };
    driving.on_link = [this](Instant, bool up, const std::optional<Error>& why) {
        scan_.on_driver_link(up, why);
    };
    auto driver = options_.open(loop_, line, scan_, driving);
    if (!driver) {
        scan_.on_open_failed(driver.error());
        return false;
    }
    driver_ = *std::move(driver);
    return true;
}

void PortScans::add(ScanTarget target, PortScan::Options options) {
    options.on_end = [this] {
        --running_;
        begin_more();
    };
    scans_.push_back(std::make_unique<PortScan>(loop_, std::move(target), std::move(options), observer_));
}

void PortScans::begin_more() {
    for (auto& scan : scans_) {
        if (running_ >= kSideBySide) return;
        if (scan->begun()) continue;
        ++running_;
        scan->begin();
    }
}

const bus::TargetScan* PortScans::current() const {
    const auto running = std::ranges::find_if(scans_, [](const auto& scan) { return scan->running(); });
    return running == scans_.end() ? nullptr : &(*running)->scan();
}

PortScans::Totals PortScans::totals() const {
    Totals totals;
    for (const auto& scan : scans_) {
        totals.done += scan->scan().done();
        totals.total += scan->scan().total();
        totals.requests += scan->scan().requests();
        totals.reached = totals.reached || scan->scan().reached();
    }
    return totals;
}

}  // namespace takt::client
