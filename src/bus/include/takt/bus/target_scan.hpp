// The scan of one port or host, setting by setting, without opening anything itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "takt/bus/scan_findings.hpp"
#include "takt/bus/scan_target.hpp"

namespace takt::bus {

/// Receives what a scan finds, from within the calls of TargetScan. Must not destroy the scan.
class ScanObserver {
public:
    virtual void on_device(const FoundDevice& device) = 0;
    virtual void on_trouble(const ScanTrouble& trouble) = 0;
    /// A host of a range accepted no connection.
    virtual void on_absent_host() = 0;

protected:
    ~ScanObserver() = default;
};

/// Runs a LineScan for one setting after the other. The owner opens the line:
///
///   while (!scan.ended()) {
///       scan.begin_setting(config of scan.line());
///       open scan.line() with the scan as its engine, or on_open_failed() when that is impossible
///       wait until setting_finished()
///       close the line; scan.end_setting();
///   }
///
/// The target is left early when its line cannot be opened, when its host accepts no connection, or when the
/// link was lost again and again. An error of one setting alone (a bit rate that the port does not have) is
/// reported, and the next setting is tried. One owner, one thread.
class TargetScan final : public Engine {
public:
    struct Options {
        ScanConfig scan;          ///< its `line` is replaced for each setting
        bool first_only = false;  ///< leave after the first setting with a device
        /// Called once for each setting when setting_finished() becomes true. It must not call end_setting(),
        /// nor close the line: both are in use by the caller.
        std::function<void()> on_setting_finished;
    };

    /// @param observer  must outlive the scan
    TargetScan(ScanTarget target, Options options, ScanObserver& observer);

    /// The line of the current setting; of the last one when the scan has ended.
    [[nodiscard]] const model::Line& line() const;

    /// @param config   the bus settings of line(), fitted to the real line
    /// @param traffic  receives every frame; may be nullptr; must outlive the setting
    void begin_setting(const bus::LineConfig& config, wire::TrafficObserver* traffic = nullptr);
    /// The line of the current setting could not be opened. Ends the setting.
    void on_open_failed(const Error& error);
    /// The link of the driver changed. Beside on_link(), which the driver calls for its engine.
    /// @param why  the error that ended the link or the attempt, where it is known
    void on_driver_link(bool up, const std::optional<Error>& why);
    /// The line is to be closed, and end_setting() to be called.
    [[nodiscard]] bool setting_finished() const;
    void end_setting();
    [[nodiscard]] bool ended() const { return ended_; }

    [[nodiscard]] bool must_reconnect() const { return scan_ && scan_->must_reconnect(); }

    /// The line was opened or the host accepted the connection at least once.
    [[nodiscard]] bool reached() const { return reached_; }
    /// Number of the current setting, from 1.
    [[nodiscard]] std::size_t setting() const;
    [[nodiscard]] std::size_t settings() const { return target_.settings.size(); }
    /// Units asked, and units to ask, over all settings.
    [[nodiscard]] std::size_t done() const;
    [[nodiscard]] std::size_t total() const { return options_.scan.units.size() * settings(); }
    [[nodiscard]] std::uint64_t requests() const;

    // The engine of the driver. Each call goes to the LineScan of the setting.
    void on_link(Instant t, bool up) override;
    /// The request in flight is repeated once on the next connection; a unit whose requests are met by closes
    /// is left.
    void on_close(Instant t) override { on_link(t, false); }
    [[nodiscard]] std::optional<Instant> opens_at() const override {
        return setting_finished() ? std::nullopt : std::optional(Instant::min());
    }
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override { return scan_->transmit(t); }
    [[nodiscard]] Instant next_wakeup() const override { return scan_->next_wakeup(); }
    [[nodiscard]] std::optional<Error> rejection() const override {
        return scan_ ? scan_->rejection() : std::nullopt;
    }

private:
    void after_engine();
    void notify_finished();
    void report(ScanTrouble::Kind kind, const Error& error = {}, std::uint8_t unit = 0);
    void next_setting(bool last);

    ScanTarget target_;
    Options options_;
    ScanObserver& observer_;
    std::size_t setting_ = 0;
    std::size_t reported_ = 0;  // devices of this setting
    int link_trouble_ = 0;      // since the last device, weighted
    bool up_ = false;
    bool gone_ = false;      // the link will not come back
    bool notified_ = false;  // of the end of this setting
    bool ended_ = false;
    bool reached_ = false;
    std::uint64_t requests_ = 0;  // of the settings before
    std::unique_ptr<LineScan> scan_;
};

}  // namespace takt::bus
