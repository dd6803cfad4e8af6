// The live values for all browsers.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "live/event_frames.hpp"
#include "live/live_values.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/web/host_access.hpp"
#include "takt/web/stream.hpp"

namespace takt::web {

/// GET /stream. One thread with one session of the host makes the events of all streams: changes of values
/// and the instants of reads at most each kTick, the state each second. Without streams there is no session.
///
/// The events are in a bounded ring. Each stream has its own cursor. A stream whose browser is too slow loses
/// its place in the ring and gets a new snapshot, so that a browser that stops reading costs nothing.
class LiveHub {
public:
    static constexpr std::size_t kMostStreams = 64;
    static constexpr auto kTick = std::chrono::milliseconds(100);

    static constexpr std::size_t kFrames = 256;

    /// @param poke    called on the hub's thread when streams have something to take
    /// @param frames  in the ring
    LiveHub(HostAccess host, std::function<void()> poke, std::size_t frames = kFrames);
    /// Ends the thread and all streams. A second call does nothing.
    void end();
    /// end(). The streams may outlive the hub.
    ~LiveHub();
    LiveHub(const LiveHub&) = delete;
    LiveHub& operator=(const LiveHub&) = delete;

    /// Any thread. @returns nullptr: kMostStreams are open
    [[nodiscard]] std::unique_ptr<StreamSource> open(text::Language language);

private:
    class Stream;

    /// Shared with the streams.
    struct Shared {
        explicit Shared(std::size_t most_frames) : frames(most_frames, std::size_t{8} << 20) {}

        std::mutex mutex;
        std::condition_variable changed;
        EventFrames frames;
        /// A list of all values that is complete with the frames from `list_next` on.
        SharedText list;
        EventFrames::Cursor list_next;
        bool list_wanted = false;
        bool ended = false;
        std::array<std::size_t, text::kLanguages.size()> streams{};  // by language

        [[nodiscard]] std::size_t count() const;
    };

    void work();
    bool wait_for_stream();
    bool wait_until(std::chrono::steady_clock::time_point when);
    void connect();
    void tick();
    void read_events();
    void take_state(Instant now);
    void push_status(const host::Snapshot& snapshot);
    void begin_configuration(bool announced);
    void put_notice(const host::Event& event);
    void push(FrameTexts texts);
    void push(std::string text);
    void make_list();
    [[nodiscard]] std::array<bool, text::kLanguages.size()> languages() const;

    HostAccess host_;
    std::function<void()> poke_;
    std::shared_ptr<Shared> shared_;
    std::unique_ptr<host::Session> session_;  // of the thread, as all below
    std::optional<LiveValues> values_;
    std::uint64_t missed_ = 0;
    int notices_ = 0;  // of this tick
    Instant next_second_;
    Instant last_frame_;
    std::thread thread_;
};

/// "info", "warning" or "error"
[[nodiscard]] std::string_view severity_of(const host::Event& event);

/// The object of GET /status: report::status_json() with `outputs`.
/// @param snapshot  with values and statistics
[[nodiscard]] file::Json status_object(const report::Texts& texts, const host::Snapshot& snapshot,
                                       const HostAccess& host);

}  // namespace takt::web
