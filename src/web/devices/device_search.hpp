// Searches that the page starts: `takt scan` and `takt probe` on a thread of their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/device_probe.hpp"
#include "takt/bus/scan_findings.hpp"
#include "takt/client/port_scan.hpp"
#include "takt/line/loop.hpp"

namespace takt::web {

/// A scan of ports and hosts.
struct ScanOrder {
    struct Target {
        bus::ScanTarget target;
        bus::ScanConfig config;
    };
    std::vector<Target> targets;
    /// Opens their lines; empty: as line::open_line().
    client::OpenLine open = {};
    std::string project_line = {};  ///< the polled line that `open` goes through
};

/// A probe of one device.
struct ProbeOrder {
    model::Line line;  ///< without devices
    UnitId unit{1};
    bus::DeviceProbeConfig config;
    Duration timeout = std::chrono::seconds(1);
    client::OpenLine open = {};     ///< as of a scan
    std::string project_line = {};  ///< likewise
    std::string name = {};          ///< of the line in errors; empty: its URL
};

/// One search at a time. It has its own event loop and connections: neither the I/O thread of the host nor a
/// thread of the server waits for it. The result stays until the next scan; probes are added to it.
///
/// Threads: every member may be called from any thread.
class DeviceSearch {
public:
    static constexpr Duration kLongest = std::chrono::hours(1);

    enum class Kind : std::uint8_t { none, scan, probe };

    struct Probed {
        model::Line line;
        std::string project_line;
        UnitId unit{1};
        bus::ProbeFindings findings;
        std::uint64_t transmissions = 0;
        Duration duration{};
        bool interrupted = false;
    };

    struct State {
        std::uint64_t id = 0;  ///< of the search, from 1
        Kind kind = Kind::none;
        bool running = false;
        bool cancelled = false;
        Duration elapsed{};
        std::size_t done = 0;  ///< units asked; of a probe requests
        std::size_t total = 0;
        std::uint64_t requests = 0;
        std::string where;           ///< URL of the line that is being searched; of a probe the next request
        std::optional<Error> error;  ///< of a probe: why there is no result
        bus::ScanFindings findings;  ///< of the last scan
        std::string project_line;    ///< the polled line that it went through; empty: none
        std::vector<Probed> probed;  ///< since that scan
    };

    DeviceSearch() = default;
    /// end()
    ~DeviceSearch();
    DeviceSearch(const DeviceSearch&) = delete;
    DeviceSearch& operator=(const DeviceSearch&) = delete;

    /// @returns the id; busy: a search is running, or end() was called
    [[nodiscard]] Result<std::uint64_t> start(ScanOrder order);
    [[nodiscard]] Result<std::uint64_t> start(ProbeOrder order);
    /// Ends the search that runs; its result so far stays.
    void cancel();
    /// cancel(), and waits for the end of its thread. No further one can be started.
    void end();

    [[nodiscard]] State state() const;

private:
    class Scan;

    [[nodiscard]] Result<std::uint64_t> start(Kind kind, std::function<void(line::Loop&)> work,
                                              std::string project_line = {});
    void run(const std::function<void(line::Loop&)>& work);
    void scan(line::Loop& loop, ScanOrder order);
    void probe(line::Loop& loop, const ProbeOrder& order);

    mutable std::mutex mutex_;
    State state_;
    Instant started_;
    std::shared_ptr<line::Loop> loop_;  // of the search that runs
    bool ended_ = false;
    std::thread thread_;
};

}  // namespace takt::web
