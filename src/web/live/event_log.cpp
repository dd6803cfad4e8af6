#include "live/event_log.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "devices/command_api.hpp"
#include "live/live_hub.hpp"
#include "live/wall_time.hpp"
#include "takt/report/states/event_report.hpp"

namespace takt::web {
namespace {

constexpr std::size_t kMostOwnSessions = 512;  // sessions of the API; each serves one request
constexpr int kMostLoggedEvents = 1'000'000;   // in a tick

}  // namespace

EventLog::EventLog(HostAccess host, Marks& marks)
    : host_(std::move(host)), marks_(marks), ticker_("takt-events", kTick, [this](bool) { work(); }) {}

void EventLog::own(host::SessionId session) {
    const std::lock_guard lock(mutex_);
    own_.push_back(session);
    if (own_.size() > kMostOwnSessions) own_.pop_front();
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
    if (!session_) {
        auto session = host_.open_session({.from_beginning = true});
        if (session) session_ = *std::move(session);
    }
    if (session_) read_events();
}

void EventLog::read_events() {
    messages_ = 0;
    for (int count = 0; count < kMostLoggedEvents; ++count) {
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
    Mark mark{.time_ms = WallTime().ms(event.t), .severity = std::string(severity_of(event))};
    for (const auto language : text::kLanguages) {
        auto line = report::event_text(report::Texts(language), *session_->configuration(), event);
        if (line.empty()) return;
        mark.texts[static_cast<std::size_t>(language)] = std::move(line);
    }
    ++messages_;
    marks_.put(std::move(mark));
}

void EventLog::add_command(const host::Outcome& outcome, const host::Configuration& configuration,
                           std::string origin) {
    Mark mark{.time_ms = WallTime().ms(outcome.t),
              .kind = Mark::Kind::command,
              .severity = "warning",
              .outcome = std::string(outcome_word(outcome)),
              .origin = std::move(origin)};
    if (mark.outcome == "done" || mark.outcome == "waiting") mark.severity = "info";
    for (const auto language : text::kLanguages)
        mark.texts[static_cast<std::size_t>(language)] =
            outcome_text(report::Texts(language), configuration, outcome);
    marks_.put(std::move(mark));
}

}  // namespace takt::web
