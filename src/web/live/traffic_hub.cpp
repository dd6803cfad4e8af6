#include "live/traffic_hub.hpp"

#include <deque>
#include <utility>
#include <vector>

#include "takt/report/times/traffic_capture.hpp"

namespace takt::web {
namespace {

constexpr int kMostTrafficRecords = 1'000'000;  // in a tick

std::string missed_event(std::uint64_t count) {
    auto object = file::Json::object();
    object.set("count", count);
    return event_text("missed", object.dump());
}

}  // namespace

struct TrafficHub::Ring final : StreamRing {
    using StreamRing::StreamRing;

    std::chrono::steady_clock::time_point tap_until;  ///< the tap stays open until then
    WireRegisters registers;

    [[nodiscard]] bool wanted() const override {
        return StreamRing::wanted() || std::chrono::steady_clock::now() < tap_until;
    }
    void clear() override {
        StreamRing::clear();
        registers.clear();
    }
    std::optional<EventFrames::Cursor> begin() override { return frames.end(); }
    void take(std::optional<EventFrames::Cursor>& cursor, text::Language language,
              std::string& out) override {
        if (frames.read(*cursor, language, out)) return;
        out += missed_event(frames.begin().items - cursor->items);
        cursor = frames.begin();
    }
};

TrafficHub::TrafficHub(HostAccess host, std::function<void()> poke)
    : TrafficHub(std::move(host), std::move(poke), std::make_shared<Ring>(256)) {}

TrafficHub::TrafficHub(HostAccess host, std::function<void()> poke, std::shared_ptr<Ring> ring)
    : StreamHub(ring, std::move(poke)), host_(std::move(host)), ring_(std::move(ring)) {
    start("takt-traffic");
}

TrafficHub::~TrafficHub() {
    end();
}

void TrafficHub::close() {
    reader_.reset();
}

void TrafficHub::registers(const std::function<void(const WireRegisters&)>& visit) {
    {
        const std::lock_guard lock(ring_->mutex);
        ring_->tap_until = std::chrono::steady_clock::now() + kTapKept;
        visit(ring_->registers);
    }
    ring_->changed.notify_all();
}

void TrafficHub::connect() {
    auto session = host_.open_session({.events = false, .traffic = true});
    if (!session) return;
    reader_.emplace(*std::move(session));
    missed_ = 0;
}

void TrafficHub::tick() {
    if (!reader_) connect();
    if (!reader_) return;
    std::vector<TrafficFrame> frames;
    std::uint64_t left_out = 0;
    bool streamed = false;
    {
        const std::lock_guard lock(ring_->mutex);
        streamed = ring_->open_streams() > 0;
    }
    for (int count = 0; count < kMostTrafficRecords; ++count) {
        auto frame = reader_->next();
        if (!frame) break;
        {
            const std::lock_guard lock(ring_->mutex);
            ring_->registers.take(*frame);
        }
        if (streamed && frames.size() < kMostFrames)
            frames.push_back(*std::move(frame));
        else
            ++left_out;
    }
    if (!streamed) left_out = 0;
    left_out += reader_->missed() - std::exchange(missed_, reader_->missed());
    const auto list = [&, clock = WallTime()](const report::Texts& texts) {
        file::Json::Array list;
        for (const auto& frame : frames) list.push_back(frame.json(clock, texts));
        return file::Json(std::move(list));
    };
    if (!frames.empty()) push("frames", list, frames.size());
    if (left_out > 0) push(missed_event(left_out));
}

Result<std::string> TrafficHub::capture() {
    bool tapped = false;
    {
        const std::lock_guard lock(ring_->mutex);
        tapped = ring_->wanted();
        ring_->tap_until = std::chrono::steady_clock::now() + kTapKept;
    }
    ring_->changed.notify_all();
    TAKT_TRY(auto session, host_.open_session({.events = false, .traffic = true, .from_beginning = true}));
    std::deque<host::TrafficRecord> last;
    for (int count = 0; count < kMostTrafficRecords; ++count) {
        auto record = session->next_traffic();
        if (!record) break;
        last.push_back(*std::move(record));
        if (last.size() > kMostCaptured) last.pop_front();
    }
    if (last.empty() && !tapped) return std::string();
    const WallTime clock;
    report::TrafficCapture capture([&](const auto& record) { return session->line_of(record); });
    std::string bytes;
    capture.frames().begin_file(bytes);
    for (const auto& record : last) capture.add(record, clock.ns(capture.end_of(record)), bytes);
    return bytes;
}

}  // namespace takt::web
