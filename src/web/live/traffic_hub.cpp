#include "live/traffic_hub.hpp"

#include <deque>
#include <utility>
#include <vector>

#include "takt/line/loop.hpp"
#include "takt/os/thread_name.hpp"
#include "takt/report/times/traffic_capture.hpp"

namespace takt::web {
namespace {

constexpr auto kTrafficTick = std::chrono::milliseconds(100);
constexpr int kMostTrafficRecords = 1'000'000;  // in a tick

std::string missed_event(std::uint64_t count) {
    auto object = file::Json::object();
    object.set("count", count);
    return event_text("missed", object.dump());
}

}  // namespace

class TrafficHub::Stream final : public StreamSource {
public:
    /// @param shared  locked
    Stream(std::shared_ptr<Shared> shared, text::Language language)
        : shared_(std::move(shared)), language_(language), cursor_(shared_->frames.end()) {
        ++streams();
    }
    ~Stream() override {
        const std::lock_guard lock(shared_->mutex);
        --streams();
    }

    bool take(std::string& out) override {
        const std::lock_guard lock(shared_->mutex);
        if (shared_->ended) return false;
        if (shared_->frames.read(cursor_, language_, out)) return true;
        const auto& begin = shared_->frames.begin();
        out += missed_event(begin.items - cursor_.items);
        cursor_ = begin;
        return true;
    }

private:
    [[nodiscard]] std::size_t& streams() { return shared_->streams[static_cast<std::size_t>(language_)]; }

    std::shared_ptr<Shared> shared_;
    text::Language language_;
    EventFrames::Cursor cursor_;
};

TrafficHub::TrafficHub(HostAccess host, std::function<void()> poke)
    : host_(std::move(host)), poke_(std::move(poke)), thread_([this] { work(); }) {}

TrafficHub::~TrafficHub() {
    end();
}

void TrafficHub::end() {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->ended = true;
    }
    shared_->changed.notify_all();
    if (thread_.joinable()) thread_.join();
}

std::unique_ptr<StreamSource> TrafficHub::open(text::Language language) {
    std::unique_ptr<StreamSource> stream;
    {
        const std::lock_guard lock(shared_->mutex);
        if (shared_->ended || shared_->open_streams() >= kMostStreams) return nullptr;
        stream = std::make_unique<Stream>(shared_, language);
    }
    shared_->changed.notify_all();
    return stream;
}

void TrafficHub::registers(const std::function<void(const WireRegisters&)>& visit) {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->registers_until = std::chrono::steady_clock::now() + kRegistersWanted;
        visit(shared_->registers);
    }
    shared_->changed.notify_all();
}

void TrafficHub::work() {
    os::name_thread("takt-traffic");
    while (wait_for_stream()) {
        if (!reader_) connect();
        if (reader_) tick();
        std::unique_lock lock(shared_->mutex);
        if (shared_->changed.wait_for(lock, kTrafficTick, [this] { return shared_->ended; })) return;
    }
}

bool TrafficHub::wait_for_stream() {
    std::unique_lock lock(shared_->mutex);
    if (!shared_->wanted() && !shared_->ended) {
        shared_->frames.clear();
        shared_->registers.clear();
        lock.unlock();
        reader_.reset();
        lock.lock();
    }
    shared_->changed.wait(lock, [this] { return shared_->ended || shared_->wanted(); });
    return !shared_->ended;
}

void TrafficHub::connect() {
    auto session = host_.open_session({.events = false, .traffic = true});
    if (!session) return;
    reader_.emplace(*std::move(session));
    missed_ = 0;
}

template <class Text>
void TrafficHub::push(Text text, std::size_t items) {
    last_frame_ = line::now();
    const std::lock_guard lock(shared_->mutex);
    shared_->frames.push(std::move(text), items);
}

void TrafficHub::tick() {
    const WallTime clock;
    std::vector<TrafficFrame> frames;
    std::uint64_t left_out = 0;
    std::array<std::size_t, text::kLanguages.size()> streams{};
    bool streamed = false;
    {
        const std::lock_guard lock(shared_->mutex);
        streams = shared_->streams;
        streamed = shared_->open_streams() > 0;
    }
    for (int count = 0; count < kMostTrafficRecords; ++count) {
        auto frame = reader_->next();
        if (!frame) break;
        {
            const std::lock_guard lock(shared_->mutex);
            shared_->registers.take(*frame);
        }
        if (streamed && frames.size() < kMostFrames)
            frames.push_back(*std::move(frame));
        else
            ++left_out;
    }
    if (!streamed) left_out = 0;
    left_out += reader_->missed() - std::exchange(missed_, reader_->missed());
    FrameTexts events;
    for (const auto language : text::kLanguages) {
        const auto index = static_cast<std::size_t>(language);
        if (streams[index] == 0) continue;
        file::Json::Array list;
        for (const auto& frame : frames) list.push_back(frame.json(clock, report::Texts(language)));
        events[index] =
            std::make_shared<const std::string>(event_text("frames", file::Json(std::move(list)).dump()));
    }
    if (!frames.empty()) push(std::move(events), frames.size());
    if (left_out > 0) push(missed_event(left_out), 0);
    if (line::now() - last_frame_ >= kKeepAliveInterval) push(std::string(": keep-alive\n\n"), 0);
    poke_();
}

Result<std::string> TrafficHub::capture() const {
    TAKT_TRY(auto session, host_.open_session({.events = false, .traffic = true, .from_beginning = true}));
    std::deque<host::TrafficRecord> last;
    for (int count = 0; count < kMostTrafficRecords; ++count) {
        auto record = session->next_traffic();
        if (!record) break;
        last.push_back(*std::move(record));
        if (last.size() > kMostCaptured) last.pop_front();
    }
    const WallTime clock;
    report::TrafficCapture capture([&](const auto& record) { return session->line_of(record); });
    std::string bytes;
    capture.frames().begin_file(bytes);
    for (const auto& record : last) capture.add(record, clock.ns(capture.end_of(record)), bytes);
    return bytes;
}

}  // namespace takt::web
