#include "takt/host/event_message.hpp"

#include <algorithm>
#include <utility>

#include "takt/wire/function.hpp"

namespace takt::host {
namespace {

using value::CommandResult;
using value::Reason;

std::string decimal(unsigned value) {
    return std::to_string(value);
}

std::vector<EventMessage::Argument> owner_arguments(const model::Line& line, const model::Device& device) {
    return {{.name = "line", .text = line.name},
            {.name = "device", .text = device.name},
            {.name = "unit", .text = decimal(device.address.value)}};
}

std::vector<EventMessage::Argument> owner_arguments(const Configuration& configuration, value::SlotId slot) {
    const auto* const line = configuration.line_of(slot);
    const auto* const device = configuration.device_of(slot);
    auto arguments = line && device ? owner_arguments(*line, *device) : std::vector<EventMessage::Argument>();
    arguments.push_back({.name = "name", .text = configuration.info(slot).name});
    return arguments;
}

std::vector<EventMessage::Argument> request_arguments(const Configuration& configuration,
                                                      const RequestKey& key,
                                                      std::optional<wire::Function> function) {
    const auto& line = configuration.project().lines[key.line];
    auto arguments = owner_arguments(line, line.devices[key.device]);
    append_request_words(arguments, function ? static_cast<std::uint8_t>(*function) : std::uint8_t{0},
                         key.start, key.quantity, true);
    return arguments;
}

/// "500", or "500..509".
std::string items_text(std::uint16_t start, std::uint16_t quantity) {
    if (quantity < 2) return decimal(start);
    return decimal(start) + ".." + decimal(start + quantity - 1U);
}

bool names_items(std::uint8_t function) {
    return wire::properties(wire::Function{function}).most_items > 0;
}

/// @param otherwise  the code of Reason::ok
void append_reason(std::vector<EventMessage::Argument>& arguments, Reason reason,
                   const std::string& otherwise) {
    if (value::is_exception(reason)) {
        const unsigned code = value::status_code(reason);
        return append_exception_words(arguments, code >= 256 ? code - 256 : code, "why");
    }
    const auto code = reason == Reason::ok ? otherwise : "app.reason." + std::string(value::name(reason));
    arguments.push_back({.name = "why", .text = code, .is_code = true});
}

// As the state of a device is shown in `ctl status` and on the page.
std::string state_code(const DeviceStateChanged& changed) {
    auto state = "app.state." + std::string(poll::name(changed.state));
    if (changed.state != poll::DeviceState::not_answering || changed.failure == Reason::ok) return state;
    if (changed.failure == Reason::bad_checksum) return "app.state.damaged";
    return changed.failure == Reason::unexpected_reply ? "app.state.unfitting" : state + ".why";
}

// A value of the project file.
std::string project_milliseconds(Duration time) {
    const bool whole = time % std::chrono::milliseconds(1) == Duration::zero();
    return whole ? std::to_string(time / std::chrono::milliseconds(1)) : milliseconds_number(time);
}

std::string cause_code(const Outcome& outcome) {
    if (outcome.trigger) return "app.write.by_trigger";
    if (outcome.id == 0) return "app.write.on_change";
    return outcome.kind == Command::Kind::set ? "app.write.by_set" : "app.write.by_write";
}

}  // namespace

void append_request_words(std::vector<EventMessage::Argument>& arguments, std::uint8_t function,
                          std::uint16_t start, std::uint16_t quantity, bool has_items) {
    const bool words = has_items && names_items(function);
    arguments.push_back({.name = "function", .text = decimal(function)});
    arguments.push_back({.name = "items", .text = items_text(start, quantity)});
    arguments.push_back({.name = "request",
                         .text = words ? "log.request." + decimal(function) : "log.request.other",
                         .is_code = true});
}

void append_exception_words(std::vector<EventMessage::Argument>& arguments, unsigned exception,
                            std::string_view argument) {
    arguments.push_back({.name = "code", .text = decimal(exception)});
    arguments.push_back({.name = "exception",
                         .text = "exception." + decimal(exception),
                         .otherwise = "exception.unknown",
                         .is_code = true});
    arguments.push_back({.name = std::string(argument), .text = "log.why.exception", .is_code = true});
}

std::uint8_t most_frequent_exception(const bus::TransactionCounters& counters) {
    const auto& codes = counters.exceptions_by_code;
    return static_cast<std::uint8_t>(std::ranges::max_element(codes) - codes.begin());
}

void append(std::vector<LogArgument>& arguments, const std::vector<EventMessage::Argument>& words) {
    for (const auto& word : words)
        arguments.push_back(
            {.name = word.name, .text = word.text, .otherwise = word.otherwise, .is_code = word.is_code});
}

std::string milliseconds_number(Duration time) {
    const auto tenths = time / std::chrono::microseconds(100);
    return std::to_string(tenths / 10) + (tenths < 100 ? "." + std::to_string(tenths % 10) : "");
}

EventMessage event_message(const Configuration& configuration, const PeriodOverrun& overrun) {
    EventMessage message{
        .code = overrun.overrun ? "app.overrun" : "app.overrun_over",
        .arguments = request_arguments(configuration, overrun.request, overrun.request.read)};
    message.arguments.push_back({.name = "period", .text = milliseconds_number(overrun.period)});
    message.arguments.push_back({.name = "real", .text = milliseconds_number(overrun.real)});
    return message;
}

EventMessage event_message(const Configuration& configuration, const WriteWaiting& waiting) {
    const auto& device = configuration.project().lines[waiting.request.line].devices[waiting.request.device];
    EventMessage message{
        .code = "app.write_waiting",
        .arguments = request_arguments(configuration, waiting.request, waiting.request.write)};
    message.arguments.push_back({.name = "name", .text = device.variables[waiting.variable].name});
    return message;
}

EventMessage event_message(const Configuration& configuration, const DelaysFound& found) {
    const auto& line = configuration.project().lines[found.line];
    std::string code = "app.delays." + std::string(poll::name(found.finding.setting));
    if (found.finding.advised == Duration::zero())
        code += ".few";
    else if (found.finding.later > 0)
        code += ".most";
    EventMessage message{.code = std::move(code),
                         .arguments = owner_arguments(line, line.devices[found.device])};
    message.arguments.push_back({.name = "delay", .text = milliseconds_number(found.finding.delay)});
    message.arguments.push_back({.name = "limit", .text = project_milliseconds(found.finding.limit)});
    message.arguments.push_back({.name = "advised", .text = project_milliseconds(found.finding.advised)});
    message.arguments.push_back({.name = "count", .text = std::to_string(found.finding.count)});
    message.arguments.push_back({.name = "later", .text = std::to_string(found.finding.later)});
    return message;
}

EventMessage event_message(const Configuration& configuration, const NoiseFound& found) {
    const auto& line = configuration.project().lines[found.line];
    const auto& [least, most] = found.finding;
    EventMessage message{.code = "app.noise", .arguments = owner_arguments(line, line.devices[found.device])};
    message.arguments.push_back(
        {.name = "count", .text = least == most ? decimal(most) : decimal(least) + ".." + decimal(most)});
    return message;
}

EventMessage event_message(const Configuration& configuration, const DeviceStateChanged& changed) {
    using Shown = DeviceStateChanged::Shown;
    if (changed.shown == Shown::counted) return {};
    const auto& line = configuration.project().lines[changed.line];
    EventMessage message{.code = "app.device_state",
                         .arguments = owner_arguments(line, line.devices[changed.device])};
    const bool sent =
        changed.state == poll::DeviceState::answering && line.is_broadcast(line.devices[changed.device]);
    const auto now = sent ? std::string("app.state.broadcast") : state_code(changed);
    auto& arguments = message.arguments;
    if (changed.failure != Reason::ok) append_reason(arguments, changed.failure, {});
    arguments.push_back({.name = "count", .text = std::to_string(changed.changes)});
    arguments.push_back({.name = "seconds", .text = std::to_string(changed.in / std::chrono::seconds(1))});
    arguments.push_back({.name = "now", .text = now, .is_code = true});
    arguments.push_back({.name = "state",
                         .text = changed.shown == Shown::each    ? now
                                 : changed.shown == Shown::often ? "app.state_often"
                                 : changed.shown == Shown::total ? "app.state_total"
                                                                 : "app.state_steady",
                         .is_code = true});
    return message;
}

EventMessage event_message(const Configuration& configuration, const SurplusFound& found) {
    const auto& line = configuration.project().lines[found.line];
    return {.code = "app.surplus", .arguments = owner_arguments(line, line.devices[found.device])};
}

EventMessage event_message(const Configuration& configuration, const GapLearnt& learnt) {
    const auto& event = learnt.gap_event;
    const auto count = event.items.last - event.items.first + 1;
    const RequestKey key{.line = learnt.line,
                         .device = event.device,
                         .read = event.read,
                         .start = event.items.first,
                         .quantity = static_cast<std::uint16_t>(count)};
    EventMessage message{.code = "app.gap_event." + std::string(poll::name(event.kind)),
                         .arguments = request_arguments(configuration, key, event.read)};
    message.arguments.push_back({.name = "count", .text = std::to_string(count)});
    append_exception_words(message.arguments, event.exception, "why");
    return message;
}

EventMessage event_message(const Configuration& configuration, const VerifyFailed& failed) {
    EventMessage message{.code = "app.verify_failed",
                         .arguments = owner_arguments(configuration, failed.slot)};
    const auto text = [&](const value::Value& value) { return configuration.value_text(failed.slot, value); };
    message.arguments.push_back({.name = "written", .text = text(failed.written)});
    message.arguments.push_back({.name = "read", .text = text(failed.read_back)});
    return message;
}

EventMessage event_message(const Configuration& configuration, const Outcome& outcome) {
    if (outcome.reason == Reason::differs) return {};
    EventMessage message{.code = "app.write." + std::string(value::name(outcome.result)),
                         .arguments = owner_arguments(configuration, outcome.slot)};
    auto& arguments = message.arguments;
    arguments.push_back({.name = "wanted", .text = configuration.value_text(outcome.slot, outcome.value)});
    if (outcome.trigger)
        arguments.push_back({.name = "trigger", .text = configuration.info(*outcome.trigger).name});
    arguments.push_back({.name = "cause", .text = cause_code(outcome), .is_code = true});
    const bool with_reason =
        outcome.result == CommandResult::refused || outcome.result == CommandResult::unknown;
    if (with_reason)
        append_reason(arguments, outcome.reason, "app.write.why." + std::string(value::name(outcome.result)));
    return message;
}

}  // namespace takt::host
