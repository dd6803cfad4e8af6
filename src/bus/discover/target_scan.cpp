#include "takt/bus/target_scan.hpp"

#include <algorithm>
#include <utility>

namespace takt::bus {
namespace {

// The scan leaves a target when the trouble of its link reaches kMostLinkTrouble: nine lost connections, or
// three attempts that made none. A device found starts the count anew.
constexpr int kLinkLost = 1;
constexpr int kNoLink = 3;
constexpr int kMostLinkTrouble = 9;

}  // namespace

TargetScan::TargetScan(ScanTarget target, Options options, ScanObserver& observer)
    : target_(std::move(target)), options_(std::move(options)), observer_(observer) {
    ended_ = target_.settings.empty();
}

const model::Line& TargetScan::line() const {
    return target_.settings[std::min(setting_, settings() - 1)];
}

std::size_t TargetScan::setting() const {
    return std::min(setting_ + 1, settings());
}

std::size_t TargetScan::done() const {
    if (ended_) return total();
    const std::size_t units = options_.scan.units.size();
    return setting_ * units + (scan_ ? std::min(scan_->visited(), units) : 0);
}

std::uint64_t TargetScan::requests() const {
    return requests_ + (scan_ ? scan_->requests() : 0);
}

void TargetScan::begin_setting(const bus::LineConfig& config, wire::TrafficObserver* traffic) {
    auto scan = options_.scan;
    scan.line = config;
    scan_ = std::make_unique<LineScan>(scan, traffic);
    reported_ = 0;
    notified_ = false;
}

void TargetScan::on_open_failed(const Error& error) {
    scan_.reset();
    report(ScanTrouble::Kind::error, error);
    next_setting(!is_of_setting(error));
}

void TargetScan::on_driver_link(bool up, const std::optional<Error>& why) {
    const bool was_up = std::exchange(up_, up);
    reached_ = reached_ || up;
    if (up) return;
    link_trouble_ += was_up ? kLinkLost : kNoLink;
    if (gone_ || (reached_ && link_trouble_ < kMostLinkTrouble)) return;
    gone_ = true;
    if (!reached_ && target_.of_range)
        observer_.on_absent_host();
    else
        report(ScanTrouble::Kind::error, why.value_or(fail(Code::connection_lost, line().name).error()));
    notify_finished();
}

bool TargetScan::setting_finished() const {
    return !scan_ || gone_ || scan_->finished();
}

void TargetScan::end_setting() {
    if (!scan_) return;
    requests_ += scan_->requests();
    for (const auto& [unit, cut_short] : scan_->garbled())
        report(ScanTrouble::Kind::garbled, cut_short ? misdirected({}, *cut_short) : Error{}, unit.value);
    if (scan_->end() == ScanEnd::line_busy) report(ScanTrouble::Kind::busy);
    if (scan_->foreign_frames() > 0) report(ScanTrouble::Kind::foreign_master);
    const bool enough = options_.first_only && !scan_->found().empty();
    scan_.reset();
    up_ = false;
    next_setting(enough || gone_);
}

void TargetScan::next_setting(bool last) {
    ++setting_;
    ended_ = last || setting_ >= settings();
}

void TargetScan::on_link(Instant t, bool up) {
    scan_->on_link(t, up);
    after_engine();
}

void TargetScan::on_bytes(Instant t, Bytes bytes) {
    scan_->on_bytes(t, bytes);
    after_engine();
}

void TargetScan::on_tick(Instant t) {
    scan_->on_tick(t);
    after_engine();
}

void TargetScan::after_engine() {
    for (; reported_ < scan_->found().size(); ++reported_) {
        observer_.on_device({line(), scan_->found()[reported_]});
        link_trouble_ = 0;
    }
    notify_finished();
}

void TargetScan::notify_finished() {
    if (!setting_finished() || std::exchange(notified_, true)) return;
    if (options_.on_setting_finished) options_.on_setting_finished();
}

void TargetScan::report(ScanTrouble::Kind kind, const Error& error, std::uint8_t unit) {
    observer_.on_trouble({kind, line(), error, unit});
}

}  // namespace takt::bus
