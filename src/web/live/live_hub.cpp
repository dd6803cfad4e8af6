#include "live/live_hub.hpp"

#include <utility>
#include <variant>

#include "live/wall_time.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/outputs_report.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::web {
namespace {

constexpr int kMostNotices = 20;            // in a tick
constexpr int kMostLiveEvents = 1'000'000;  // likewise

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

struct LiveHub::Ring final : StreamRing {
    using StreamRing::StreamRing;

    /// A list of all values that is complete with the frames from `list_next` on.
    SharedText list;
    EventFrames::Cursor list_next;
    bool list_wanted = false;

    void clear() override {
        StreamRing::clear();
        list.reset();
    }
    std::optional<EventFrames::Cursor> begin() override {
        list_wanted = true;
        return std::nullopt;
    }
    void take(std::optional<EventFrames::Cursor>& cursor, text::Language language,
              std::string& out) override {
        if (cursor && frames.read(*cursor, language, out)) return;
        cursor.reset();
        if (!list || list_next.frame < frames.begin().frame) {
            list_wanted = true;
            return;
        }
        cursor = list_next;
        out += *list;
    }
};

LiveHub::LiveHub(HostAccess host, std::function<void()> poke, std::size_t frames)
    : LiveHub(std::move(host), std::move(poke), std::make_shared<Ring>(frames)) {}

LiveHub::LiveHub(HostAccess host, std::function<void()> poke, std::shared_ptr<Ring> ring)
    : StreamHub(ring, std::move(poke)), host_(std::move(host)), ring_(std::move(ring)) {
    start("takt-live");
}

LiveHub::~LiveHub() {
    end();
}

void LiveHub::close() {
    session_.reset();
    values_.reset();
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
    if (!snapshot) return close();
    values_.emplace(*snapshot);
    next_second_ = snapshot->t;
    if (!announced) return;
    auto object = file::Json::object();
    object.set("generation", snapshot->configuration->generation());
    push(event_text("configuration", object.dump()));
    push(event_text("snapshot", values_->list_text(snapshot->t)));
}

void LiveHub::tick() {
    if (!session_) connect();
    if (!session_) return;
    notices_ = 0;
    read_events();
    if (!session_) return;
    const Instant now = line::now();
    take_state(now);
    if (!session_) return;
    if (values_->changed()) push(event_text("values", values_->take_rows_text(now)));
    if (values_->read()) push(event_text("reads", values_->take_reads_text(now)));
    make_list();
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
    push("notice", [&](const report::Texts& texts) -> file::Json {
        auto line = report::event_text(texts, *values_->configuration(), event);
        if (line.empty()) return {};
        auto object = file::Json::object();
        object.set("time", WallTime().ms(event.t));
        object.set("severity", severity_of(event));
        object.set("text", std::move(line));
        return object;
    });
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
    if (second)
        push("status", [&](const report::Texts& texts) { return status_object(texts, *snapshot, host_); });
}

// One list for all streams that need one. It follows the frames that were pushed so far.
void LiveHub::make_list() {
    {
        const std::lock_guard lock(ring_->mutex);
        if (!ring_->list_wanted) return;
    }
    auto text = std::make_shared<const std::string>(event_text("snapshot", values_->list_text(line::now())));
    const std::lock_guard lock(ring_->mutex);
    ring_->list = std::move(text);
    ring_->list_next = ring_->frames.end();
    ring_->list_wanted = false;
}

file::Json status_object(const report::Texts& texts, const host::Snapshot& snapshot, const HostAccess& host) {
    auto status = report::status_json(texts, snapshot, utc_text(snapshot.t));
    const auto outputs = host.outputs ? host.outputs() : std::vector<publish::OutputStatus>();
    status.set("outputs", report::outputs_json(texts, outputs, WallTime().ms(snapshot.t) * 1'000'000));
    return status;
}

}  // namespace takt::web
