// Streams of server-sent events that one thread feeds.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "live/event_frames.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/web/stream.hpp"

namespace takt::web {

/// What a hub shares with its streams, which may outlive it.
struct StreamRing {
    explicit StreamRing(std::size_t most_frames) : frames(most_frames, std::size_t{8} << 20) {}
    virtual ~StreamRing() = default;

    std::mutex mutex;  // of all below, and held while a virtual function is called
    std::condition_variable changed;
    EventFrames frames;
    std::array<std::size_t, text::kLanguages.size()> streams{};  // by language
    bool ended = false;

    [[nodiscard]] std::size_t open_streams() const;

    /// The thread works.
    [[nodiscard]] virtual bool wanted() const { return open_streams() > 0; }
    virtual void clear() { frames.clear(); }
    /// @returns where a new stream begins; nothing: take() decides it
    [[nodiscard]] virtual std::optional<EventFrames::Cursor> begin() = 0;
    /// As StreamSource::take().
    virtual void take(std::optional<EventFrames::Cursor>& cursor, text::Language language,
                      std::string& out) = 0;
};

/// The events are in a bounded ring. Each stream has its own cursor: a browser that stops reading costs
/// nothing. A thread fills the ring each kTick while there are streams. A derived class starts it when it is
/// complete, and ends it in its destructor.
class StreamHub {
public:
    static constexpr std::size_t kMostStreams = 64;
    static constexpr auto kTick = std::chrono::milliseconds(100);

    StreamHub(const StreamHub&) = delete;
    StreamHub& operator=(const StreamHub&) = delete;

    /// Ends the thread and all streams. A second call does nothing.
    void end();
    /// Any thread. @returns nullptr: kMostStreams are open
    [[nodiscard]] std::unique_ptr<StreamSource> open(text::Language language);

protected:
    /// @param poke  called on the hub's thread when streams have something to take
    StreamHub(std::shared_ptr<StreamRing> ring, std::function<void()> poke);
    virtual ~StreamHub() = default;
    void start(const char* thread);

    // All below: on the thread.
    virtual void tick() = 0;
    /// Nothing is wanted any more: no events are queued without a reader.
    virtual void close() = 0;

    void push(std::string text);
    /// An event in each language that has a stream. @param data  of null: no event
    /// @param items  how many things it reports
    void push(std::string_view event, const std::function<file::Json(const report::Texts&)>& data,
              std::size_t items = 0);

private:
    class Stream;

    void work(const char* name);
    bool wait_until_wanted();

    std::shared_ptr<StreamRing> ring_;
    std::function<void()> poke_;
    Instant last_frame_;  // of the thread
    std::thread thread_;
};

}  // namespace takt::web
