#include "sessions/failure_log.hpp"

#include <string>
#include <string_view>
#include <vector>

#include "takt/host/event_message.hpp"

namespace takt::host {
namespace {

std::string seconds(Duration time) {
    return std::to_string((time + std::chrono::milliseconds(500)) / std::chrono::seconds(1));
}

std::string_view attempt_code(poll::FailedExchange::Kind kind) {
    using enum poll::FailedExchange::Kind;
    switch (kind) {
        case attempt: return "log.attempt";
        case probe: return "log.attempt.probe";
        case relayed: break;
    }
    return "log.attempt.relayed";
}

}  // namespace

FailureLog::FailureLog(const Log& log, const model::Project& project) : log_(log), project_(project) {}

void FailureLog::on_failed(Instant t, std::size_t line, const poll::FailedExchange& failed) {
    if (!log_.enabled()) return;
    Kind kind{line, failed, {}};
    kind.exchange->took = {};
    auto& instead = kind.exchange->instead;
    if (instead && instead->part == Mismatch::Part::transaction)
        instead->came = instead->asked = 0;  // they differ each time
    if (filter_.admit(t, kind)) write(kind, failed.took, 0);
}

void FailureLog::on_link_down(std::size_t line, const std::optional<Error>& why, std::uint64_t repeated,
                              Duration in) {
    if (log_.enabled()) write({line, {}, why.value_or(Error{.code = Code::connection_lost})}, in, repeated);
}

void FailureLog::on_link_closed(Instant t, std::size_t line, const Error& why) {
    if (!log_.enabled()) return;
    const Kind kind{line, {}, why, true};
    if (filter_.admit(t, kind)) write(kind, {}, 0);
}

// The first bytes of a header are its transaction id, which differs each time.
bool FailureLog::same_error(const Error& a, const Error& b) {
    if (a.code != Code::not_modbus || b.code != Code::not_modbus) return a == b;
    return a.subject == b.subject && a.numbers[2] == b.numbers[2];
}

void FailureLog::on_link_up(Instant t, std::size_t line) {
    filter_.end(
        t, [line](const Kind& kind) { return !kind.exchange && kind.line == line; },
        [this](const Kind& kind, std::uint64_t count, Duration in) { write(kind, in, count); });
}

void FailureLog::on_tick(Instant t) {
    filter_.sweep(
        t, [this](const Kind& kind, std::uint64_t count, Duration in) { write(kind, in, count); },
        [this](std::uint64_t count, Duration in) { write_omitted(count, in); });
}

void FailureLog::finish(Instant t) {
    filter_.finish(
        t, [this](const Kind& kind, std::uint64_t count, Duration in) { write(kind, in, count); },
        [this](std::uint64_t count, Duration in) { write_omitted(count, in); });
}

// An argument may use those before it: the sink makes the text of a code with them.
void FailureLog::write(const Kind& kind, Duration time, std::uint64_t repeated) const {
    const auto& line = project_.lines[kind.line];
    const auto count = std::to_string(repeated);
    const auto in = seconds(time);
    std::vector<LogArgument> arguments{{.name = "line", .text = line.name},
                                       {.name = "count", .text = count},
                                       {.name = "seconds", .text = in}};
    if (kind.closed && kind.error.code != Code::not_modbus)
        return log_.message(LogLevel::info, repeated > 0 ? "log.link_closed_repeated" : "log.link_closed",
                            arguments);
    if (!kind.exchange) {
        arguments.push_back({.name = "error", .error = &kind.error});
        return log_.message(LogLevel::warning, repeated > 0 ? "log.link_repeated" : "log.link_down",
                            arguments);
    }
    const auto& failed = *kind.exchange;
    const auto number = [](auto value) { return std::to_string(static_cast<unsigned>(value)); };
    const auto unit = number(failed.unit.value);
    const auto attempt = number(failed.attempt);
    const auto attempts = number(failed.attempts);
    const auto took = milliseconds_number(time);
    std::vector<EventMessage::Argument> words;
    append_request_words(words, failed.request.function, failed.request.start.value, failed.request.quantity,
                         failed.request.decoded);
    if (failed.status == bus::Status::exception)
        append_exception_words(words, failed.exception, "why");
    else if (failed.instead) {
        const auto& [part, came, asked] = *failed.instead;
        words.push_back({.name = "whole", .text = number(asked)});
        words.push_back({.name = "other", .text = number(came)});
        words.push_back(
            {.name = "why", .text = "log.why.other_" + std::string(takt::name(part)), .is_code = true});
    } else
        words.push_back(
            {.name = "why", .text = "log.why." + std::string(bus::name(failed.status)), .is_code = true});
    for (const LogArgument& argument :
         {LogArgument{.name = "unit", .text = unit}, LogArgument{.name = "number", .text = attempt},
          LogArgument{.name = "attempts", .text = attempts},
          LogArgument{.name = "milliseconds", .text = took}})
        arguments.push_back(argument);
    append(arguments, words);
    if (failed.device) arguments.push_back({.name = "device", .text = line.devices[*failed.device].name});
    arguments.push_back(
        {.name = "where", .text = failed.device ? "log.device" : "log.unit", .is_code = true});
    arguments.push_back({.name = "attempt", .text = attempt_code(failed.kind), .is_code = true});
    log_.message(LogLevel::info, repeated > 0 ? "log.exchange_repeated" : "log.exchange_failed", arguments);
}

void FailureLog::write_omitted(std::uint64_t count, Duration in) const {
    const auto number = std::to_string(count);
    const auto time = seconds(in);
    const LogArgument arguments[] = {{.name = "count", .text = number}, {.name = "seconds", .text = time}};
    log_.message(LogLevel::info, "log.omitted", arguments);
}

}  // namespace takt::host
