// The frames on the lines for all browsers.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "live/stream_hub.hpp"
#include "live/traffic_reader.hpp"
#include "live/wire_registers.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

/// GET /traffic, GET /traffic/capture, GET /registers: the frames of one tap. The tap is closed when no
/// stream is open and neither registers nor a capture were asked for during kTapKept. Frames that a slow
/// browser, or this thread, could not take are counted in the event `missed`.
class TrafficHub final : public StreamHub {
public:
    static constexpr std::size_t kMostFrames = 1000;  ///< in one event, of a tenth of a second
    static constexpr std::size_t kMostCaptured = 10'000;
    static constexpr auto kTapKept = std::chrono::seconds(10);

    TrafficHub(HostAccess host, std::function<void()> poke);
    ~TrafficHub() override;

    /// The last frames that a tap saw, as pcapng, and keeps the tap open for some time. Any thread. @returns
    /// empty: there was neither a tap nor a frame, the tap opens now; the errors of open_session
    [[nodiscard]] Result<std::string> capture();

    /// Calls `visit` with the registers of the frames since the tap was opened, and keeps the tap open for
    /// some time. Any thread; other calls wait until it returns.
    void registers(const std::function<void(const WireRegisters&)>& visit);

private:
    struct Ring;

    TrafficHub(HostAccess host, std::function<void()> poke, std::shared_ptr<Ring> ring);
    void tick() override;
    void close() override;
    void connect();

    HostAccess host_;
    std::shared_ptr<Ring> ring_;
    std::optional<TrafficReader> reader_;  // of the thread, as all below
    std::uint64_t missed_ = 0;
};

}  // namespace takt::web
