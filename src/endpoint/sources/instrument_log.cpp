#include "sources/instrument_log.hpp"

#include <string>
#include <utility>
#include <vector>

namespace takt::endpoint {
namespace {

using EventKind = InstrumentEvent::Kind;

constexpr int kLink = -1;

LogLevel level_of(EventKind kind) {
    switch (kind) {
        case EventKind::reset_line:
        case EventKind::silence_ended:
        case EventKind::ready: return LogLevel::info;
        default: return LogLevel::warning;
    }
}

std::string_view code_of(EventKind kind) {
    switch (kind) {
        case EventKind::reset_line: return "log.instrument.reset_line";
        case EventKind::silence_ended: return "log.instrument.silence_ended";
        case EventKind::ready: return "log.instrument.ready";
        case EventKind::start_failed: return "log.instrument.start_failed";
        case EventKind::restore_failed: return "log.instrument.restore_failed";
        case EventKind::silent: return "log.instrument.silent";
        case EventKind::write_failed: return "log.instrument.write_failed";
        case EventKind::setting_dropped: return "log.instrument.setting_dropped";
    }
    return {};
}

std::string_view code_of(WriteResult result) {
    switch (result) {
        case WriteResult::done: break;
        case WriteResult::refused: return "log.instrument.why.refused";
        case WriteResult::differs: return "log.instrument.why.differs";
        case WriteResult::no_answer: return "log.instrument.why.no_answer";
        case WriteResult::expired: return "log.instrument.why.expired";
    }
    return "log.instrument.why.refused";
}

}  // namespace

/// Keys are few: kinds, results and commands are limited.
bool InstrumentLog::admit(Instant t, const Key& key) {
    auto& written = written_[key];
    if (written.at && t - *written.at < kWindow) {
        ++written.omitted;
        return false;
    }
    written.at = t;
    if (const auto count = std::to_string(std::exchange(written.omitted, 0)); count != "0")
        log_.message(LogLevel::info, "log.instrument.omitted",
                     std::vector<LogArgument>{{.name = "instrument", .text = settings_.name},
                                              {.name = "count", .text = count}});
    return true;
}

void InstrumentLog::on_link(Instant t, bool up, const std::optional<Error>& why) {
    const Error error = why.value_or(Error{.code = Code::connection_lost});
    if (!log_.enabled() || !admit(t, {kLink, up ? 1U : 0U, up ? 0 : static_cast<int>(error.code)})) return;
    std::vector<LogArgument> arguments{{.name = "instrument", .text = settings_.name}};
    if (up) return log_.message(LogLevel::info, "log.instrument.link_up", arguments);
    arguments.push_back({.name = "error", .error = &error});
    log_.message(LogLevel::warning, "log.instrument.link_down", arguments);
}

void InstrumentLog::on_event(Instant t, const InstrumentEvent& event) {
    if (!log_.enabled() ||
        !admit(t, {static_cast<int>(event.kind), event.number, static_cast<int>(event.result)}))
        return;
    const bool of_command = event.kind == EventKind::restore_failed ||
                            event.kind == EventKind::write_failed || event.kind == EventKind::setting_dropped;
    const auto* const command = of_command ? &settings_.commands[event.number] : nullptr;
    const auto number =
        std::to_string(event.kind == EventKind::start_failed ? event.number + 1 : event.number);
    std::string value(event.text);
    if (command != nullptr && !command->unit.empty()) value += " " + command->unit;
    const auto seconds = std::to_string(settings_.start_retry / std::chrono::milliseconds(1)) + " ms";
    log_.message(level_of(event.kind), code_of(event.kind),
                 std::vector<LogArgument>{
                     {.name = "instrument", .text = settings_.name},
                     {.name = "number", .text = number},
                     {.name = "value", .text = value},
                     {.name = "command", .text = command != nullptr ? std::string_view(command->name) : ""},
                     {.name = "retry", .text = seconds},
                     {.name = "why", .text = code_of(event.result), .is_code = true}});
}

}  // namespace takt::endpoint
