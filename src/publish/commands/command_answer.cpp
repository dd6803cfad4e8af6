#include "commands/command_answer.hpp"

#include <variant>

#include "takt/base/iso_time.hpp"
#include "takt/base/utf8.hpp"
#include "takt/host/value_json.hpp"
#include "takt/publish/message_format.hpp"

namespace takt::publish {
namespace {

using file::Json;
using Kind = host::Command::Kind;

constexpr std::size_t kLongestAudited = 200;  // bytes of a string

Json json_of(const value::SlotInfo& info, const value::Value& value) {
    return host::to_json(info.type, info.scaled, value);
}

CommandAnswer begun(const CommandRequest& request, std::int64_t wall_ns) {
    CommandAnswer answer{.wall_ns = wall_ns};
    answer.id = request.id;
    answer.variable = request.subject;
    if (!request.subject.empty()) answer.command = name(request.verb);
    return answer;
}

/// The value as the request has it.
Json given_value(const CommandRequest& request) {
    if (!request.value) return {};
    if (request.form != CommandRequest::ValueForm::other) return Json(*request.value);
    return Json::parse(*request.value).value_or(Json(*request.value));
}

CommandEnd end_of(const host::Outcome& outcome) {
    if (outcome.error) return CommandEnd::refused;
    switch (outcome.result) {
        case value::CommandResult::done: return CommandEnd::done;
        case value::CommandResult::refused:
        case value::CommandResult::queue_full: return CommandEnd::refused;
        case value::CommandResult::unknown: return CommandEnd::unknown;
        case value::CommandResult::expired: return CommandEnd::expired;
    }
    return CommandEnd::unknown;
}

std::string_view reason_of(const host::Outcome& outcome) {
    using Progress = host::Outcome::Progress;
    if (outcome.error) return takt::name(outcome.error->code);
    if (outcome.reason != value::Reason::ok) return value::name(outcome.reason);
    if (outcome.result == value::CommandResult::expired || outcome.result == value::CommandResult::queue_full)
        return value::name(outcome.result);
    if (outcome.result != value::CommandResult::done) return {};
    if (outcome.progress == Progress::superseded) return "superseded";
    if (outcome.progress == Progress::waiting) return "waiting";
    if (outcome.not_retained) return "not_retained";
    if (outcome.rounded) return "rounded";
    return outcome.progress == Progress::not_written ? "not_written" : "";
}

std::string cut(const std::string& text) {
    const auto front = whole_characters(text, kLongestAudited);
    return front.size() == text.size() ? text : std::string(front) + "…";
}

void set(Json& object, std::string_view key, const std::string& text) {
    if (!text.empty()) object.set(key, text);
}

}  // namespace

std::string_view name(CommandEnd end) {
    switch (end) {
        case CommandEnd::done: return "done";
        case CommandEnd::refused: return "refused";
        case CommandEnd::unknown: return "unknown";
        case CommandEnd::expired: return "expired";
    }
    return "";
}

CommandAnswer answer_of(const CommandRequest& request, const CommandRefused& refused, std::int64_t wall_ns) {
    auto answer = begun(request, wall_ns);
    answer.end = refused.why == CommandRefusal::expired ? CommandEnd::expired : CommandEnd::refused;
    answer.reason = name(refused.why);
    answer.detail = refused.detail;
    answer.value = given_value(request);
    return answer;
}

CommandAnswer answer_of(const CommandRequest& request, const host::Outcome& outcome,
                        const host::Configuration& configuration, std::int64_t wall_ns) {
    auto answer = begun(request, wall_ns);
    answer.end = end_of(outcome);
    answer.reason = reason_of(outcome);
    if (outcome.error) answer.detail = outcome.error->subject.view();
    const auto& info = configuration.info(outcome.slot);
    answer.value = json_of(info, outcome.value);
    answer.read_back = json_of(info, outcome.read_back);
    if (value::is_exception(outcome.reason))
        answer.detail = "Modbus exception " + std::to_string(value::status_code(outcome.reason) & 0xFFU);
    if (outcome.kind != Kind::get || outcome.error) return answer;
    answer.quality = value::name(outcome.quality);
    // Both clocks are those of this moment: the wall clock may have been set since the value was read.
    if (outcome.good_at) answer.last_good_ns = wall_ns - (outcome.t - *outcome.good_at).count();
    return answer;
}

std::string answer_message(const CommandAnswer& answer) {
    auto object = Json::object();
    object.set("id", answer.id.empty() ? Json() : Json(answer.id));
    set(object, "command", answer.command);
    set(object, "variable", answer.variable);
    object.set("outcome", name(answer.end));
    set(object, "reason", answer.reason);
    set(object, "detail", answer.detail);
    if (!answer.value.is_null()) object.set("value", answer.value);
    set(object, "quality", answer.quality);
    if (answer.last_good_ns) object.set("last_good", utc_time_text(*answer.last_good_ns));
    if (!answer.read_back.is_null()) object.set("read_back", answer.read_back);
    object.set("time", utc_time_text(answer.wall_ns));
    return object.dump();
}

std::string short_answer_message(const CommandAnswer& answer) {
    auto object = Json::object();
    object.set("id", answer.id.empty() ? Json() : Json(answer.id));
    object.set("outcome", name(answer.end));
    set(object, "reason", answer.reason);
    object.set("shortened", true);
    object.set("time", utc_time_text(answer.wall_ns));
    return object.dump();
}

std::string missing_lines_text(std::string_view output, std::uint64_t count, std::int64_t wall_ns) {
    auto object = Json::object();
    object.set("time", utc_time_text(wall_ns));
    object.set("event", "lines_missing");
    object.set("output", output);
    object.set("count", count);
    return object.dump() + '\n';
}

std::string audit_line(const CommandOrigin& origin, const CommandAnswer& answer) {
    auto object = Json::object();
    object.set("time", utc_time_text(answer.wall_ns));
    object.set("event", "command");
    object.set("output", origin.output);
    object.set("broker", origin.broker);
    object.set("topic", cut(origin.topic));
    set(object, "id", answer.id);
    set(object, "command", answer.command);
    set(object, "variable", cut(answer.variable));
    const auto* const text = std::get_if<std::string>(&answer.value.value());
    if (!answer.value.is_null()) object.set("value", text == nullptr ? answer.value : Json(cut(*text)));
    object.set("outcome", name(answer.end));
    set(object, "reason", answer.reason);
    return object.dump() + '\n';
}

}  // namespace takt::publish
