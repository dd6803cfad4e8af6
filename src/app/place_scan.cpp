#include "takt/app/place_scan.hpp"

#include <algorithm>
#include <utility>

#include "takt/app/client.hpp"

namespace takt::app {
namespace {

constexpr Duration kLeastConnectLimit = std::chrono::seconds(1);

// A connection that is lost counts once, one that cannot be made three times; a device found clears the
// account.
constexpr int kLinkLost = 1;
constexpr int kNoLink = 3;
constexpr int kMostLinkTrouble = 9;

// Says nothing of other settings of the same port.
bool is_of_setting(const Error& error) {
    return error.code == Code::unsupported || error.code == Code::out_of_range;
}

}  // namespace

PlaceScan::PlaceScan(line::Loop& loop, const ScanPlace& place, Options options, ScanNews& news)
    : loop_(loop), place_(place), options_(std::move(options)), news_(news), step_(loop, [this](Instant) {
          next();
      }) {}

void PlaceScan::begin() {
    begun_ = true;
    step_.set(line::now());
}

const line::Target& PlaceScan::target() const {
    return place_.settings[std::min(setting_, place_.settings.size() - 1)];
}

std::size_t PlaceScan::setting() const {
    return std::min(setting_ + 1, settings());
}

std::size_t PlaceScan::done() const {
    if (ended_) return total();
    const std::size_t units = options_.scan.units.size();
    return setting_ * units + (scan_ ? std::min(scan_->visited(), units) : 0);
}

std::uint64_t PlaceScan::requests() const {
    return requests_ + (scan_ ? scan_->requests() : 0);
}

void PlaceScan::on_link(Instant t, bool up) {
    scan_->on_link(t, up);
    look();
}

void PlaceScan::on_bytes(Instant t, Bytes bytes) {
    scan_->on_bytes(t, bytes);
    look();
}

void PlaceScan::on_tick(Instant t) {
    scan_->on_tick(t);
    look();
}

// The driver may not be destroyed from within its call: next() comes from the timer.
void PlaceScan::look() {
    for (; told_ < scan_->found().size(); ++told_) {
        news_.on_device({target().as_line(), scan_->found()[told_]});
        link_trouble_ = 0;
    }
    if (scan_->finished()) step_.set(line::now());
}

void PlaceScan::next() {
    if (scan_) close_setting();
    while (!ended_ && !scan_) {
        if (setting_ >= place_.settings.size()) return end();
        if (!open_setting()) ++setting_;
    }
}

bool PlaceScan::open_setting() {
    auto config = options_.scan;
    config.line = one_off_line(target());
    if (options_.log)
        traffic_ =
            std::make_unique<LineTraffic>(*options_.log, target().as_line(), LineTraffic::Side::master);
    scan_ = std::make_unique<discover::LineScan>(config, traffic_.get());
    told_ = 0;
    line::DriverOptions driving;
    driving.connect_limit = std::max(config.wait, kLeastConnectLimit);
    driving.must_reconnect = [this] { return scan_->must_reconnect(); };
    driving.on_link = [this](Instant t, bool up, const std::optional<Error>& why) {
        on_driver_link(t, up, why);
    };
    auto driver = line::open_target(loop_, target(), *this, driving);
    if (driver) {
        driver_ = *std::move(driver);
        return true;
    }
    scan_.reset();
    news_.on_trouble({discover::ScanTrouble::Kind::error, target().as_line(), driver.error(), 0});
    if (!is_of_setting(driver.error())) end();
    return false;
}

void PlaceScan::close_setting() {
    driver_.reset();
    requests_ += scan_->requests();
    for (const auto unit : scan_->garbled())
        news_.on_trouble({discover::ScanTrouble::Kind::garbled, target().as_line(), {}, unit.value});
    if (scan_->end() == discover::ScanEnd::line_busy)
        news_.on_trouble({discover::ScanTrouble::Kind::busy, target().as_line(), {}, 0});
    if (scan_->strangers() > 0)
        news_.on_trouble({discover::ScanTrouble::Kind::strangers, target().as_line(), {}, 0});
    const bool enough = options_.first_only && !scan_->found().empty();
    scan_.reset();
    up_ = false;
    ++setting_;
    if (enough || gone_) end();
}

// The driver tries again by itself until the place is left.
void PlaceScan::on_driver_link(Instant t, bool up, const std::optional<Error>& why) {
    const bool was_up = std::exchange(up_, up);
    reached_ = reached_ || up;
    if (up) return;
    link_trouble_ += was_up ? kLinkLost : kNoLink;
    if (gone_ || (reached_ && link_trouble_ < kMostLinkTrouble)) return;
    gone_ = true;
    const auto lost = fail(Code::connection_lost, target().as_line().name).error();
    if (!reached_ && place_.of_many)
        news_.on_absent();
    else
        news_.on_trouble({discover::ScanTrouble::Kind::error, target().as_line(), why.value_or(lost), 0});
    step_.set(t);
}

void PlaceScan::end() {
    if (std::exchange(ended_, true)) return;
    news_.on_end();
}

}  // namespace takt::app
