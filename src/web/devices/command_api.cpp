#include "devices/command_api.hpp"

#include <optional>
#include <utility>
#include <variant>

#include "devices/command_preview.hpp"
#include "live/event_log.hpp"
#include "live/live_values.hpp"
#include "live/state_api.hpp"
#include "takt/file/json_members.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/states/command_report.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/text/frame_text.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::web {
namespace {

using host::Command;
using value::CommandResult;

constexpr Duration kCommandExpires = std::chrono::seconds(5);
constexpr Duration kOutcomeLimit = std::chrono::seconds(12);  // longer than a set waits
constexpr Duration kOutcomeSlice = std::chrono::milliseconds(100);

/// The body of a command.
struct Asked {
    std::string kind;
    std::string variable;
    std::string value;
};

std::optional<Asked> asked_of(const ApiRequest& request) {
    const auto body = file::Json::parse(request.body, kMostCommandBody);
    if (!body) return std::nullopt;
    const auto* const variable = text_in(member(*body, "variable"));
    if (!variable) return std::nullopt;
    return Asked{.kind = body->find("kind") ? scalar_text(member(*body, "kind")) : "write",
                 .variable = *variable,
                 .value = scalar_text(member(*body, "value"))};
}

ApiResponse unknown_variable(const ApiRequest& request, const std::string& name) {
    return ApiResponse::error(404, "variable", request.texts("web.error.variable", {{"name", name}}));
}

ApiResponse wrong_value(const ApiRequest& request, const Error& error) {
    return ApiResponse::error(422, name(error.code), request.texts.describe(error));
}

}  // namespace

std::string_view outcome_word(const host::Outcome& outcome) {
    if (outcome.error) return "refused";
    switch (outcome.result) {
        case CommandResult::done: break;
        case CommandResult::refused:
        case CommandResult::queue_full: return "refused";
        case CommandResult::unknown: return "unknown";
        case CommandResult::expired: return "expired";
    }
    switch (outcome.progress) {
        case host::Outcome::Progress::settled:
        case host::Outcome::Progress::not_written: return "done";
        case host::Outcome::Progress::waiting: return "waiting";
        case host::Outcome::Progress::superseded: break;
    }
    return "refused";
}

namespace {

/// What an executed command proves: the suffix of its text.
std::string_view proof_word(const host::Configuration& configuration, const host::Outcome& outcome) {
    const auto* const variable = configuration.variable_of(outcome.slot);
    if (variable == nullptr || outcome.kind != Command::Kind::write) return "done";
    if (configuration.line_of(outcome.slot)->is_broadcast(*configuration.device_of(outcome.slot)))
        return "broadcast";
    return variable->verify ? "verified" : "acknowledged";
}

/// The value that the device holds: the nearest one to that asked for.
value::Value held_value(const host::Configuration& configuration, const host::Outcome& outcome) {
    const auto* const variable = configuration.variable_of(outcome.slot);
    if (variable == nullptr || !outcome.rounded) return outcome.value;
    const auto layout = value::layout_of(*variable);
    const auto encoded = value::encode(layout, outcome.value);
    if (!encoded) return outcome.value;
    return value::decode(layout, encoded->registers).value_or(outcome.value);
}

}  // namespace

std::string outcome_text(const report::Texts& texts, const host::Configuration& configuration,
                         const host::Outcome& outcome) {
    if (outcome.error) return texts.describe(*outcome.error);
    if (outcome.result != CommandResult::done)
        return report::event_text(texts, configuration, {.body = host::WriteFinished{outcome}});
    if (const auto text = report::not_written_text(texts, configuration, outcome); !text.empty()) return text;
    const auto word = outcome_word(outcome);
    return texts("web.command." + std::string(word == "done" ? proof_word(configuration, outcome) : word),
                 {{"name", configuration.info(outcome.slot).name},
                  {"value", configuration.value_text(outcome.slot, held_value(configuration, outcome))}});
}

namespace {

std::string reason_of(const host::Outcome& outcome) {
    if (outcome.error) return std::string(name(outcome.error->code));
    if (outcome.result == CommandResult::queue_full) return "queue_full";
    if (outcome.progress == host::Outcome::Progress::superseded) return "superseded";
    if (outcome.progress == host::Outcome::Progress::not_written) return "not_written";
    return report::reason_word(outcome.reason);
}

file::Json outcome_object(const report::Texts& texts, const host::Configuration& configuration,
                          const host::Outcome& outcome) {
    auto object = file::Json::object();
    object.set("outcome", outcome_word(outcome));
    object.set("reason", reason_of(outcome));
    object.set("text", outcome_text(texts, configuration, outcome));
    const auto& info = configuration.info(outcome.slot);
    const auto set_value = [&](const char* key, const value::Value& value) {
        if (!value::is_empty(value)) object.set(key, report::to_json(info.type, info.scaled, value));
    };
    set_value("written", outcome.written);
    set_value("read_back", outcome.read_back);
    if (outcome.rounded) object.set("rounded", true);
    return object;
}

/// Commands of one request.
class Sender {
public:
    Sender(std::unique_ptr<host::Session> session, const std::atomic<bool>& stopping)
        : session_(std::move(session)), stopping_(stopping) {}

    [[nodiscard]] const host::Configuration& configuration() const { return *session_->configuration(); }
    [[nodiscard]] host::SessionId id() const { return session_->id(); }

    /// Blocks until the outcome is there. @returns timed_out; the errors of submit()
    Result<host::Outcome> send(Command command) {
        static_cast<void>(session_->configuration());
        command.expires = line::now() + kCommandExpires;
        TAKT_CHECK(session_->submit(command));
        const Instant limit = line::now() + kOutcomeLimit;
        while (line::now() < limit && !stopping_) {
            session_->wait(kOutcomeSlice);
            if (auto outcome = session_->next_outcome()) return *std::move(outcome);
        }
        return fail(Code::timed_out, "command", kOutcomeLimit / std::chrono::milliseconds(1));
    }

private:
    std::unique_ptr<host::Session> session_;
    const std::atomic<bool>& stopping_;
};

ApiResponse command_response(const HostAccess& host, EventLog& log, const std::atomic<bool>& stopping,
                             const ApiRequest& request) {
    const auto asked = asked_of(request);
    if (!asked) return malformed_body(request);
    const bool trigger = asked->kind == "trigger";
    if (!trigger && asked->kind != "set" && asked->kind != "write") return malformed_body(request);
    auto session = host.open_session({.events = false});
    if (!session) return host_error(request, session.error());
    Sender sender(*std::move(session), stopping);
    const auto slot = sender.configuration().find(asked->variable);
    if (!slot) return unknown_variable(request, asked->variable);
    const auto info = sender.configuration().info(*slot);
    if (trigger && (!info.local || info.type != DataType::boolean)) return malformed_body(request);
    log.own(sender.id());
    Result<host::Outcome> outcome = fail(Code::unsupported);
    if (trigger) {
        outcome = sender.send({.kind = Command::Kind::pull, .slot = *slot, .value = {}});
    } else {
        auto value = value::parse(info.type, info.scaled, asked->value);
        if (!value) return wrong_value(request, value.error());
        const bool write = asked->kind == "write" && !info.local;
        outcome = sender.send({.kind = write ? Command::Kind::write : Command::Kind::set,
                               .slot = *slot,
                               .value = *std::move(value)});
    }
    if (!outcome) return host_error(request, outcome.error());
    log.add(*outcome, sender.configuration(), request.peer);
    return ApiResponse::json(outcome_object(request.texts, sender.configuration(), *outcome));
}

ApiResponse preview_response(const HostAccess& host, const ApiRequest& request) {
    const auto asked = asked_of(request);
    if (!asked) return malformed_body(request);
    const auto snapshot = take_snapshot(host, {.values = true, .statistics = true, .plan = true});
    if (!snapshot) return host_error(request, snapshot.error());
    const auto& configuration = *snapshot->configuration;
    const auto slot = configuration.find(asked->variable);
    if (!slot) return unknown_variable(request, asked->variable);
    const auto& info = configuration.info(*slot);
    const auto value = value::parse(info.type, info.scaled, asked->value);
    if (!value) return wrong_value(request, value.error());
    const auto shown = preview(*snapshot, *slot, *value);
    if (!shown) return wrong_value(request, shown.error());
    auto frames = file::Json::array();
    for (const auto& frame : shown->frames) {
        auto object = file::Json::object();
        object.set("raw", wire::hex(frame.raw));
        object.set("words", text::frame_text(request.texts.language(), frame.words));
        object.set("bus_time_us", std::chrono::ceil<std::chrono::microseconds>(frame.bus_time).count());
        frames.push_back(std::move(object));
    }
    auto object = file::Json::object();
    object.set("frames", std::move(frames));
    object.set("value_written", report::to_json(info.type, info.scaled, shown->written));
    object.set("rounded", shown->rounded);
    return ApiResponse::json(object);
}

/// Any variable of a device.
std::optional<value::SlotId> slot_of_device(const host::Configuration& configuration, const std::string& line,
                                            const std::string& device) {
    const auto& lines = configuration.project().lines;
    for (std::size_t l = 0; l < lines.size(); ++l)
        for (std::size_t d = 0; lines[l].name == line && d < lines[l].devices.size(); ++d)
            if (lines[l].devices[d].name == device && !lines[l].devices[d].variables.empty())
                return configuration.slots().variable({l, d, 0});
    return std::nullopt;
}

ApiResponse device_probe_response(const HostAccess& host, const std::atomic<bool>& stopping,
                                  const ApiRequest& request) {
    const auto body = file::Json::parse(request.body, kMostCommandBody);
    const auto line = body ? string_member(*body, "line") : std::string();
    const auto device = body ? string_member(*body, "device") : std::string();
    if (device.empty()) return malformed_body(request);
    auto session = host.open_session({.events = false});
    if (!session) return host_error(request, session.error());
    Sender sender(*std::move(session), stopping);
    const auto slot = slot_of_device(sender.configuration(), line, device);
    if (!slot)
        return ApiResponse::error(404, "device",
                                  request.texts("web.error.device", {{"line", line}, {"device", device}}));
    const auto outcome = sender.send({.kind = Command::Kind::probe, .slot = *slot, .value = {}});
    if (!outcome) return host_error(request, outcome.error());
    const bool begun = outcome->result == CommandResult::done && !outcome->error;
    const bool no_link = outcome->reason == value::Reason::link_lost;
    auto object = file::Json::object();
    object.set("outcome", begun ? "done" : "refused");
    object.set("reason", report::reason_word(outcome->reason));
    object.set("text", request.texts(begun     ? "web.probe.started"
                                     : no_link ? "web.probe.no_link"
                                               : "web.probe.not_needed",
                                     {{"device", device}, {"line", line}}));
    return ApiResponse::json(object);
}

}  // namespace

std::vector<ApiRoute> command_routes(const HostAccess& host, EventLog& log,
                                     const std::atomic<bool>& stopping) {
    using enum Method;
    return {
        {post, "/commands", true,
         [&](const ApiRequest& request) { return command_response(host, log, stopping, request); },
         Work::device},
        {post, "/commands/preview", false,
         [&](const ApiRequest& request) { return preview_response(host, request); }},
        {post, "/devices/probe", true,
         [&](const ApiRequest& request) { return device_probe_response(host, stopping, request); },
         Work::device},
    };
}

}  // namespace takt::web
