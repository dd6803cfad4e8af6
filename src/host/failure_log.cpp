#include "failure_log.hpp"

#include <string>
#include <string_view>
#include <vector>

#include "takt/wire/function.hpp"

namespace takt::host {
namespace {

std::string milliseconds(Duration time) {
    const auto tenths = time / std::chrono::microseconds(100);
    return std::to_string(tenths / 10) + (tenths < 100 ? "." + std::to_string(tenths % 10) : "");
}

std::string seconds(Duration time) {
    return std::to_string((time + std::chrono::milliseconds(500)) / std::chrono::seconds(1));
}

/// "500", or "500..509".
std::string items(const wire::RequestShape& request) {
    const unsigned first = request.start.value;
    if (request.quantity < 2) return std::to_string(first);
    return std::to_string(first) + ".." + std::to_string(first + request.quantity - 1U);
}

bool has_items(std::uint8_t function) {
    using enum wire::Function;
    switch (static_cast<wire::Function>(function)) {
        case read_coils:
        case read_discrete_inputs:
        case read_holding_registers:
        case read_input_registers:
        case write_single_coil:
        case write_single_register:
        case write_multiple_coils:
        case write_multiple_registers:
        case mask_write_register:
        case read_write_multiple_registers: return true;
        default: return false;
    }
}

}  // namespace

FailureLog::FailureLog(const Log& log, const model::Project& project) : log_(log), project_(project) {}

void FailureLog::on_failed(Instant t, std::size_t line, const poll::FailedExchange& failed) {
    if (!log_.enabled()) return;
    Kind kind{line, failed, {}};
    kind.exchange->took = {};
    if (filter_.admit(t, kind)) write(kind, failed.took, 0);
}

void FailureLog::on_link_down(Instant t, std::size_t line, const std::optional<Error>& why) {
    if (!log_.enabled()) return;
    const Kind kind{line, {}, why.value_or(Error{.code = Code::connection_lost})};
    if (filter_.admit(t, kind)) write(kind, {}, 0);
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
    if (!kind.exchange) {
        arguments.push_back({.name = "error", .error = &kind.error});
        return log_.message(LogLevel::warning, repeated > 0 ? "log.link_repeated" : "log.link_down",
                            arguments);
    }
    const auto& failed = *kind.exchange;
    const auto number = [](auto value) { return std::to_string(static_cast<unsigned>(value)); };
    const auto unit = number(failed.unit.value);
    const auto function = number(failed.request.function);
    const auto code = number(failed.exception);
    const auto attempt = number(failed.attempt);
    const auto attempts = number(failed.attempts);
    const auto items = host::items(failed.request);
    const auto took = milliseconds(time);
    const bool words = failed.request.decoded && has_items(failed.request.function);
    const auto request = words ? "log.request." + function : std::string("log.request.other");
    const auto name = "exception." + code;
    const auto why = "log.why." + std::string(bus::name(failed.status));
    for (const LogArgument& argument :
         {LogArgument{.name = "unit", .text = unit}, LogArgument{.name = "function", .text = function},
          LogArgument{.name = "items", .text = items}, LogArgument{.name = "code", .text = code},
          LogArgument{.name = "attempt", .text = attempt}, LogArgument{.name = "attempts", .text = attempts},
          LogArgument{.name = "milliseconds", .text = took},
          LogArgument{.name = "name", .text = name, .otherwise = "exception.unknown", .is_code = true},
          LogArgument{.name = "request", .text = request, .is_code = true},
          LogArgument{.name = "why", .text = why, .is_code = true}})
        arguments.push_back(argument);
    if (failed.device) arguments.push_back({.name = "device", .text = line.devices[*failed.device].name});
    std::string message = failed.device ? "log.exchange_" : "log.relayed_";
    message += repeated > 0 ? "repeated" : "failed";
    log_.message(LogLevel::info, message, arguments);
}

void FailureLog::write_omitted(std::uint64_t count, Duration in) const {
    const auto number = std::to_string(count);
    const auto time = seconds(in);
    const LogArgument arguments[] = {{.name = "count", .text = number}, {.name = "seconds", .text = time}};
    log_.message(LogLevel::info, "log.omitted", arguments);
}

}  // namespace takt::host
