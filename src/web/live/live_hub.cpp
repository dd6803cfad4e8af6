#include "live/live_hub.hpp"

#include <utility>
#include <variant>

#include "live/wall_time.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/thread_name.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/outputs_report.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::web {
namespace {

constexpr int kMostNotices = 20;            // in a tick
constexpr int kMostLiveEvents = 1'000'000;  // likewise

std::size_t language_index(text::Language language) {
    return static_cast<std::size_t>(language);
}

}  // namespace

std::string_view severity_of(const host::Event& event) {
    if (const auto* const notice = std::get_if<host::Notice>(&event.body)) {
        if (notice->severity == host::Notice::Severity::error) return "error";
        return notice->severity == host::Notice::Severity::warning ? "warning" : "info";
    }
    if (const auto* const link = std::get_if<host::LinkChanged>(&event.body))
        return link->up ? "info" : "warning";
    if (const auto* const device = std::get_if<host::DeviceStateChanged>(&event.body))
        return device->state == poll::DeviceState::not_answering ||
                       device->shown == host::DeviceStateChanged::Shown::often
                   ? "warning"
                   : "info";
    if (const auto* const overrun = std::get_if<host::PeriodOverrun>(&event.body))
        return overrun->overrun ? "warning" : "info";
    if (std::holds_alternative<host::GapLearnt>(event.body)) return "info";
    return "warning";
}

class LiveHub::Stream final : public StreamSource {
public:
    Stream(std::shared_ptr<Shared> shared, text::Language language)
        : shared_(std::move(shared)), language_(language) {}
    ~Stream() override {
        const std::lock_guard lock(shared_->mutex);
        --shared_->streams[language_index(language_)];
    }

    bool take(std::string& out) override {
        const std::lock_guard lock(shared_->mutex);
        if (shared_->ended) return false;
        if (has_list_ && shared_->frames.read(cursor_, language_, out)) return true;
        has_list_ = shared_->list && shared_->list_next.frame >= shared_->frames.begin().frame;
        if (!has_list_) {
            shared_->list_wanted = true;
            return true;
        }
        cursor_ = shared_->list_next;
        out += *shared_->list;
        return true;
    }

private:
    std::shared_ptr<Shared> shared_;
    text::Language language_;
    bool has_list_ = false;
    EventFrames::Cursor cursor_;
};

std::size_t LiveHub::Shared::count() const {
    std::size_t sum = 0;
    for (const auto of_language : streams) sum += of_language;
    return sum;
}

LiveHub::LiveHub(HostAccess host, std::function<void()> poke, std::size_t frames)
    : host_(std::move(host)),
      poke_(std::move(poke)),
      shared_(std::make_shared<Shared>(frames)),
      thread_([this] { work(); }) {}

LiveHub::~LiveHub() {
    end();
}

void LiveHub::end() {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->ended = true;
    }
    shared_->changed.notify_all();
    if (thread_.joinable()) thread_.join();
}

std::unique_ptr<StreamSource> LiveHub::open(text::Language language) {
    {
        const std::lock_guard lock(shared_->mutex);
        if (shared_->ended || shared_->count() >= kMostStreams) return nullptr;
        ++shared_->streams[language_index(language)];
        shared_->list_wanted = true;
    }
    shared_->changed.notify_all();
    return std::make_unique<Stream>(shared_, language);
}

void LiveHub::work() {
    os::name_thread("takt-live");
    auto next = std::chrono::steady_clock::now();
    for (;;) {
        if (!wait_for_stream()) return;
        if (!session_) {
            connect();
            next = std::chrono::steady_clock::now();
        }
        if (session_) tick();
        // A tick that took longer than its time is followed by one whole pause.
        next = std::max(next + kTick, std::chrono::steady_clock::now());
        if (!wait_until(next)) return;
    }
}

// Without streams the session is closed, so no events are queued without a reader. @returns false at the end
bool LiveHub::wait_for_stream() {
    std::unique_lock lock(shared_->mutex);
    if (shared_->count() == 0 && !shared_->ended) {
        shared_->frames.clear();
        shared_->list.reset();
        lock.unlock();
        session_.reset();
        values_.reset();
        lock.lock();
    }
    shared_->changed.wait(lock, [this] { return shared_->ended || shared_->count() > 0; });
    return !shared_->ended;
}

bool LiveHub::wait_until(std::chrono::steady_clock::time_point when) {
    std::unique_lock lock(shared_->mutex);
    return !shared_->changed.wait_until(lock, when, [this] { return shared_->ended; });
}

void LiveHub::connect() {
    auto session = host_.open_session({});
    if (!session) return;
    session_ = *std::move(session);
    missed_ = 0;
    begin_configuration(false);
}

// The events that the session gets from now on may be older than the snapshot. They lead to its state again.
void LiveHub::begin_configuration(bool announced) {
    const auto snapshot = session_->snapshot({.values = true, .statistics = true});
    if (!snapshot) {
        session_.reset();
        values_.reset();
        return;
    }
    values_.emplace(*snapshot);
    next_second_ = snapshot->t;
    if (!announced) return;
    auto object = file::Json::object();
    object.set("generation", snapshot->configuration->generation());
    push(event_text("configuration", object.dump()));
    push(event_text("snapshot", values_->list_text(snapshot->t)));
}

void LiveHub::tick() {
    notices_ = 0;
    read_events();
    if (!session_) return;
    const Instant now = line::now();
    take_state(now);
    if (!session_) return;
    if (values_->changed()) push(event_text("values", values_->take_rows_text(now)));
    if (values_->read()) push(event_text("reads", values_->take_reads_text(now)));
    if (now - last_frame_ >= kKeepAliveInterval) push(": keep-alive\n\n");
    make_list();
    poke_();
}

void LiveHub::read_events() {
    for (int count = 0; count < kMostLiveEvents; ++count) {
        const auto event = session_->next_event();
        if (!event) break;
        const bool current = event->generation == values_->configuration()->generation();
        if (const auto* const changed = std::get_if<host::ValueChanged>(&event->body)) {
            if (current) values_->apply(*changed);
        } else if (std::holds_alternative<host::ConfigurationChanged>(event->body)) {
            if (!current) begin_configuration(true);
            if (!session_) return;
        } else if (current) {
            put_notice(*event);
        }
    }
    if (session_->missed_events() == missed_) return;
    missed_ = session_->missed_events();
    next_second_ = line::now();  // the snapshot has what the lost events said
}

void LiveHub::put_notice(const host::Event& event) {
    if (std::holds_alternative<host::AuditRecorded>(event.body) || ++notices_ > kMostNotices) return;
    const auto wanted = languages();
    FrameTexts texts;
    for (const auto language : text::kLanguages) {
        if (!wanted[language_index(language)]) continue;
        auto line = report::event_text(report::Texts(language), *values_->configuration(), event);
        if (line.empty()) return;
        auto object = file::Json::object();
        object.set("time", WallTime().ms(event.t));
        object.set("severity", severity_of(event));
        object.set("text", std::move(line));
        texts[language_index(language)] =
            std::make_shared<const std::string>(event_text("notice", object.dump()));
    }
    push(std::move(texts));
}

// No event reports the reads of values that stay the same: their instants come from a copy at each tick.
void LiveHub::take_state(Instant now) {
    const bool second = now >= next_second_;
    const auto snapshot = session_->snapshot({.values = true, .statistics = second});
    if (!snapshot) return session_.reset();
    if (second) next_second_ = std::max(next_second_ + std::chrono::seconds(1), snapshot->t);
    if (snapshot->configuration->generation() != values_->configuration()->generation())
        return;  // its event follows
    values_->refresh(*snapshot);
    if (second) push_status(*snapshot);
}

void LiveHub::push_status(const host::Snapshot& snapshot) {
    const auto wanted = languages();
    FrameTexts texts;
    for (const auto language : text::kLanguages) {
        if (!wanted[language_index(language)]) continue;
        const auto status = status_object(report::Texts(language), snapshot, host_);
        texts[language_index(language)] =
            std::make_shared<const std::string>(event_text("status", status.dump()));
    }
    push(std::move(texts));
}

std::array<bool, text::kLanguages.size()> LiveHub::languages() const {
    const std::lock_guard lock(shared_->mutex);
    std::array<bool, text::kLanguages.size()> result{};
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = shared_->streams[i] > 0;
    return result;
}

void LiveHub::push(FrameTexts texts) {
    last_frame_ = line::now();
    const std::lock_guard lock(shared_->mutex);
    shared_->frames.push(std::move(texts));
}

void LiveHub::push(std::string text) {
    last_frame_ = line::now();
    const std::lock_guard lock(shared_->mutex);
    shared_->frames.push(std::move(text));
}

// One list for all streams that need one. It follows the frames that were pushed so far.
void LiveHub::make_list() {
    {
        const std::lock_guard lock(shared_->mutex);
        if (!shared_->list_wanted) return;
    }
    auto text = std::make_shared<const std::string>(event_text("snapshot", values_->list_text(line::now())));
    const std::lock_guard lock(shared_->mutex);
    shared_->list = std::move(text);
    shared_->list_next = shared_->frames.end();
    shared_->list_wanted = false;
}

file::Json status_object(const report::Texts& texts, const host::Snapshot& snapshot, const HostAccess& host) {
    auto status = report::status_json(texts, snapshot, utc_text(snapshot.t));
    const auto outputs = host.outputs ? host.outputs() : std::vector<publish::OutputStatus>();
    status.set("outputs", report::outputs_json(texts, outputs, WallTime().ms(snapshot.t) * 1'000'000));
    return status;
}

}  // namespace takt::web
