#include "event_log.hpp"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "command_api.hpp"
#include "live_hub.hpp"
#include "takt/report/event_report.hpp"
#include "wall_time.hpp"

namespace takt::web {
namespace {

constexpr std::size_t kMostOwn = 512;   // sessions of the API; each serves one request
constexpr int kMostEvents = 1'000'000;  // in a tick

}  // namespace

EventLog::EventLog(HostAccess host)
    : host_(std::move(host)), since_ms_(WallTime().ms(host_.started)), thread_([this] { work(); }) {}

EventLog::~EventLog() {
    end();
}

void EventLog::end() {
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void EventLog::own(host::SessionId session) {
    const std::lock_guard lock(mutex_);
    own_.push_back(session);
    if (own_.size() > kMostOwn) own_.pop_front();
}

bool EventLog::is_own(host::SessionId session) const {
    const std::lock_guard lock(mutex_);
    return std::ranges::find(own_, session) != own_.end();
}

void EventLog::add(const host::Outcome& outcome, const host::Configuration& configuration,
                   std::string address) {
    add_command(outcome, configuration, std::move(address));
}

void EventLog::work() {
    std::unique_lock lock(mutex_);
    while (!ended_) {
        lock.unlock();
        if (!session_) {
            auto session = host_.open_session({.from_beginning = true});
            if (session) session_ = *std::move(session);
        }
        if (session_) read_events();
        lock.lock();
        changed_.wait_for(lock, kTick, [this] { return ended_; });
    }
}

void EventLog::read_events() {
    messages_ = 0;
    for (int count = 0; count < kMostEvents; ++count) {
        const auto event = session_->next_event();
        if (!event) break;
        if (!std::holds_alternative<host::ValueChanged>(event->body)) add(*event);
    }
    const auto missed = session_->missed_events();
    if (missed == missed_) return;
    add({.t = line::now(), .body = host::EventsLost{missed - missed_}});
    missed_ = missed;
}

void EventLog::add(const host::Event& event) {
    const auto* const finished = std::get_if<host::WriteFinished>(&event.body);
    if (finished != nullptr && finished->outcome.id != 0) {
        if (!is_own(finished->session)) add_command(finished->outcome, *session_->configuration(), {});
        return;
    }
    if (std::holds_alternative<host::AuditRecorded>(event.body) || messages_ >= kMostMessages) return;
    Entry entry{.time_ms = WallTime().ms(event.t), .kind = "message", .severity = severity_of(event)};
    for (const auto language : text::kLanguages) {
        auto line = report::event_text(report::Texts(language), *session_->configuration(), event);
        if (line.empty()) return;
        entry.texts[static_cast<std::size_t>(language)] = std::move(line);
    }
    ++messages_;
    put(notices_, std::move(entry));
}

void EventLog::add_command(const host::Outcome& outcome, const host::Configuration& configuration,
                           std::string origin) {
    Entry entry{.time_ms = WallTime().ms(outcome.t),
                .kind = "command",
                .severity = "warning",
                .outcome = outcome_word(outcome),
                .origin = std::move(origin)};
    if (entry.outcome == "done" || entry.outcome == "waiting") entry.severity = "info";
    for (const auto language : text::kLanguages)
        entry.texts[static_cast<std::size_t>(language)] =
            outcome_text(report::Texts(language), configuration, outcome);
    put(commands_, std::move(entry));
}

void EventLog::put(std::deque<Entry>& list, Entry entry) {
    const std::lock_guard lock(mutex_);
    list.push_back(std::move(entry));
    if (list.size() <= kMost) return;
    since_ms_ = std::max(since_ms_, list.front().time_ms + 1);
    list.pop_front();
}

file::Json EventLog::events(text::Language language, std::int64_t from_ms, std::int64_t to_ms) const {
    const std::lock_guard lock(mutex_);
    std::vector<const Entry*> found;
    for (const auto* const list : {&commands_, &notices_})
        for (const auto& entry : *list)
            if (entry.time_ms >= from_ms && entry.time_ms < to_ms) found.push_back(&entry);
    std::ranges::stable_sort(found, {}, &Entry::time_ms);
    auto list = file::Json::array();
    for (const auto* const entry : found) {
        auto object = file::Json::object();
        object.set("time", entry->time_ms);
        object.set("kind", entry->kind);
        object.set("severity", entry->severity);
        object.set("text", entry->texts[static_cast<std::size_t>(language)]);
        if (!entry->outcome.empty()) object.set("outcome", entry->outcome);
        if (!entry->origin.empty()) object.set("origin", entry->origin);
        list.push_back(std::move(object));
    }
    auto object = file::Json::object();
    object.set("since", since_ms_);
    object.set("events", std::move(list));
    return object;
}

}  // namespace takt::web
