#include "live/stream_hub.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "takt/line/loop.hpp"
#include "takt/os/thread_name.hpp"

namespace takt::web {

class StreamHub::Stream final : public StreamSource {
public:
    /// @param ring  locked
    Stream(std::shared_ptr<StreamRing> ring, text::Language language)
        : ring_(std::move(ring)), language_(language), cursor_(ring_->begin()) {
        ++streams();
    }
    ~Stream() override {
        const std::lock_guard lock(ring_->mutex);
        --streams();
    }

    bool take(std::string& out) override {
        const std::lock_guard lock(ring_->mutex);
        if (ring_->ended) return false;
        ring_->take(cursor_, language_, out);
        return true;
    }

private:
    [[nodiscard]] std::size_t& streams() { return ring_->streams[static_cast<std::size_t>(language_)]; }

    std::shared_ptr<StreamRing> ring_;
    text::Language language_;
    std::optional<EventFrames::Cursor> cursor_;
};

std::size_t StreamRing::open_streams() const {
    return std::accumulate(streams.begin(), streams.end(), std::size_t{0});
}

StreamHub::StreamHub(std::shared_ptr<StreamRing> ring, std::function<void()> poke)
    : ring_(std::move(ring)), poke_(std::move(poke)) {}

void StreamHub::start(const char* thread) {
    thread_ = std::thread([this, thread] { work(thread); });
}

void StreamHub::end() {
    {
        const std::lock_guard lock(ring_->mutex);
        ring_->ended = true;
    }
    ring_->changed.notify_all();
    if (thread_.joinable()) thread_.join();
}

std::unique_ptr<StreamSource> StreamHub::open(text::Language language) {
    std::unique_ptr<StreamSource> stream;
    {
        const std::lock_guard lock(ring_->mutex);
        if (ring_->ended || ring_->open_streams() >= kMostStreams) return nullptr;
        stream = std::make_unique<Stream>(ring_, language);
    }
    ring_->changed.notify_all();
    return stream;
}

void StreamHub::work(const char* name) {
    os::name_thread(name);
    while (wait_until_wanted()) {
        tick();
        if (line::now() - last_frame_ >= kKeepAliveInterval) push(": keep-alive\n\n");
        poke_();
        std::unique_lock lock(ring_->mutex);
        if (ring_->changed.wait_for(lock, kTick, [this] { return ring_->ended; })) return;
    }
}

// @returns false at the end
bool StreamHub::wait_until_wanted() {
    std::unique_lock lock(ring_->mutex);
    if (!ring_->wanted() && !ring_->ended) {
        ring_->clear();
        lock.unlock();
        close();
        lock.lock();
    }
    ring_->changed.wait(lock, [this] { return ring_->ended || ring_->wanted(); });
    return !ring_->ended;
}

void StreamHub::push(std::string text) {
    last_frame_ = line::now();
    const std::lock_guard lock(ring_->mutex);
    ring_->frames.push(std::move(text));
}

void StreamHub::push(std::string_view event, const std::function<file::Json(const report::Texts&)>& data,
                     std::size_t items) {
    std::array<std::size_t, text::kLanguages.size()> streams{};
    {
        const std::lock_guard lock(ring_->mutex);
        streams = ring_->streams;
    }
    FrameTexts texts;
    for (const auto language : text::kLanguages) {
        const auto index = static_cast<std::size_t>(language);
        if (streams[index] == 0) continue;
        const auto object = data(report::Texts(language));
        if (object.is_null()) return;
        texts[index] = std::make_shared<const std::string>(event_text(event, object.dump()));
    }
    last_frame_ = line::now();
    const std::lock_guard lock(ring_->mutex);
    ring_->frames.push(std::move(texts), items);
}

}  // namespace takt::web
