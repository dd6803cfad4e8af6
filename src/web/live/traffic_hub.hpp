// The frames on the lines for all browsers.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <string>
#include <thread>

#include "live/event_frames.hpp"
#include "live/traffic_reader.hpp"
#include "live/wire_registers.hpp"
#include "takt/web/host_access.hpp"
#include "takt/web/stream.hpp"

namespace takt::web {

/// GET /traffic, GET /traffic/capture, GET /registers. One thread with one tap for all streams; the tap is
/// closed when no stream is open and no registers were asked for during kRegistersWanted. Frames that a slow
/// browser, or this thread, could not take are counted in the event `missed`.
class TrafficHub {
public:
    static constexpr std::size_t kMostStreams = 64;
    static constexpr std::size_t kMostFrames = 1000;  ///< in one event, of a tenth of a second
    static constexpr std::size_t kMostCaptured = 10'000;
    static constexpr auto kRegistersWanted = std::chrono::seconds(10);

    /// @param poke  called on the hub's thread when streams have something to take
    TrafficHub(HostAccess host, std::function<void()> poke);
    /// Ends the thread and all streams. A second call does nothing.
    void end();
    /// end(). The streams may outlive the hub.
    ~TrafficHub();
    TrafficHub(const TrafficHub&) = delete;
    TrafficHub& operator=(const TrafficHub&) = delete;

    /// Any thread. @returns nullptr: kMostStreams are open
    [[nodiscard]] std::unique_ptr<StreamSource> open(text::Language language);

    /// The last frames that a tap saw, as pcapng. Any thread. @returns the errors of open_session
    [[nodiscard]] Result<std::string> capture() const;

    /// Calls `visit` with the registers of the frames since the tap was opened, and keeps the tap open for
    /// some time. Any thread; other calls wait until it returns.
    void registers(const std::function<void(const WireRegisters&)>& visit);

private:
    class Stream;

    struct Shared {
        std::mutex mutex;
        std::condition_variable changed;
        EventFrames frames{256, std::size_t{8} << 20};
        std::array<std::size_t, text::kLanguages.size()> streams{};  ///< in each language
        bool ended = false;
        std::chrono::steady_clock::time_point registers_until;  ///< the tap stays open until then
        WireRegisters registers;

        [[nodiscard]] std::size_t open_streams() const {
            return std::accumulate(streams.begin(), streams.end(), std::size_t{0});
        }
        [[nodiscard]] bool wanted() const {
            return open_streams() > 0 || std::chrono::steady_clock::now() < registers_until;
        }
    };

    void work();
    bool wait_for_stream();
    void connect();
    void tick();
    template <class Text>
    void push(Text text, std::size_t items);

    HostAccess host_;
    std::function<void()> poke_;
    std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
    std::optional<TrafficReader> reader_;  // of the thread, as all below
    std::uint64_t missed_ = 0;
    Instant last_frame_;
    std::thread thread_;
};

}  // namespace takt::web
