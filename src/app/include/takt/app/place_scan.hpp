// The scan of one port or host, setting by setting.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "takt/app/scan_places.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/discover/line_scan.hpp"
#include "takt/discover/scan_findings.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"

namespace takt::app {

/// Told of what a scan finds, on the loop's thread. Must not destroy the scan.
class ScanNews {
public:
    virtual void on_device(const discover::FoundDevice& device) = 0;
    virtual void on_trouble(const discover::ScanTrouble& trouble) = 0;
    /// A host of a range takes no connection.
    virtual void on_absent() = 0;
    /// The last call.
    virtual void on_end() = 0;

protected:
    ~ScanNews() = default;
};

/// Opens a place with one setting after the other, and runs a discover::LineScan on each. A port that cannot
/// be opened, or a host that takes no connection or hangs up again and again, is left.
class PlaceScan final : private Engine {
public:
    struct Options {
        discover::ScanConfig scan;  ///< its `line` is that of each setting
        bool first_only = false;    ///< leave after the first setting that found something
        TrafficLog* log = nullptr;
    };

    /// @param loop, news  outlive it
    PlaceScan(line::Loop& loop, const ScanPlace& place, Options options, ScanNews& news);

    void begin();
    [[nodiscard]] bool begun() const { return begun_; }
    [[nodiscard]] bool ended() const { return ended_; }
    /// The port was opened, the host was connected to, once at least.
    [[nodiscard]] bool reached() const { return reached_; }
    [[nodiscard]] const line::Target& target() const;
    /// Number of the setting at work, from 1.
    [[nodiscard]] std::size_t setting() const;
    [[nodiscard]] std::size_t settings() const { return place_.settings.size(); }
    /// Units asked and to be asked, over all settings.
    [[nodiscard]] std::size_t done() const;
    [[nodiscard]] std::size_t total() const { return options_.scan.units.size() * settings(); }
    [[nodiscard]] std::uint64_t requests() const;

private:
    // Engine: the driver's, which hands everything to the scan of the setting
    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    Bytes transmit(Instant t) override { return scan_->transmit(t); }
    Instant next_wakeup() const override { return scan_->next_wakeup(); }

    void look();
    void next();
    bool open_setting();
    void close_setting();
    void on_driver_link(Instant t, bool up, const std::optional<Error>& why);
    void end();

    line::Loop& loop_;
    ScanPlace place_;
    Options options_;
    ScanNews& news_;
    std::size_t setting_ = 0;
    std::size_t told_ = 0;  // devices of this setting
    int link_trouble_ = 0;
    bool up_ = false;
    bool gone_ = false;  // the link, for good
    bool begun_ = false;
    bool ended_ = false;
    bool reached_ = false;
    std::uint64_t requests_ = 0;  // of the settings before
    std::unique_ptr<LineTraffic> traffic_;
    std::unique_ptr<discover::LineScan> scan_;
    std::unique_ptr<line::Driver> driver_;
    line::Timer step_;
};

}  // namespace takt::app
