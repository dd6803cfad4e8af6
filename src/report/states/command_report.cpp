#include "takt/report/states/command_report.hpp"

#include <fmt/format.h>

#include "takt/report/drawing/value_json.hpp"
#include "takt/report/states/state_report.hpp"
#include "takt/text/escape.hpp"
#include "takt/value/text.hpp"

namespace takt::report {
namespace {

using host::Command;
using value::CommandResult;

constexpr std::string_view command_word(Command::Kind kind) {
    switch (kind) {
        case Command::Kind::set: return "set";
        case Command::Kind::write: return "write";
        case Command::Kind::get: return "get";
        case Command::Kind::pull: return "trigger";
        case Command::Kind::probe: return "probe";
        case Command::Kind::exchange: return "exchange";
    }
    return "";
}

constexpr std::string_view progress_word(host::Outcome::Progress progress) {
    switch (progress) {
        case host::Outcome::Progress::settled: return "";
        case host::Outcome::Progress::waiting: return "waiting";
        case host::Outcome::Progress::superseded: return "superseded";
        case host::Outcome::Progress::not_written: return "not_written";
    }
    return "";
}

void append_word(std::string& line, std::string_view text) {
    if (text.empty()) return;
    line += ' ';
    line += text;
}

/// A `write` always ends with a result; a `set` or `get` that went well is simply acknowledged.
bool is_acknowledged(const host::Outcome& outcome) {
    return outcome.kind != Command::Kind::write && outcome.result == CommandResult::done;
}

value::SlotInfo info_of(const host::Configuration& configuration, const host::Outcome& outcome) {
    if (!outcome.service) return configuration.info(outcome.slot);
    return {.name = model::ServiceNames(configuration.project()).name(*outcome.service),
            .type = outcome.service->field->type,
            .local = true,
            .service = true};
}

/// The texts of an outcome's values.
struct ValueTexts {
    ValueTexts(const host::Configuration& configuration, const host::Outcome& outcome)
        : info(info_of(configuration, outcome)),
          value(value::format(info.type, info.scaled, outcome.value)),
          written(value::format(info.type, info.scaled, outcome.written)),
          read_back(value::format(info.type, info.scaled, outcome.read_back)) {}

    value::SlotInfo info;
    std::string value;
    std::string written;
    std::string read_back;
};

std::string acknowledged_line(const ValueTexts& texts, const host::Outcome& outcome) {
    std::string line = "ok";
    append_word(line, texts.info.name);
    append_word(line, texts.value);
    append_word(line, progress_word(outcome.progress));
    return line;
}

std::string result_line(const ValueTexts& texts, const host::Outcome& outcome) {
    std::string line(value::name(outcome.result));
    append_word(line, texts.info.name);
    append_word(line, reason_word(outcome.reason));
    if (!texts.read_back.empty())
        line += " written " + texts.written + " read " + texts.read_back;
    else if (outcome.result != CommandResult::done)
        line += " wanted " + texts.value;
    return line;
}

}  // namespace

std::string reason_word(value::Reason reason) {
    if (reason == value::Reason::ok) return {};
    if (!value::is_exception(reason)) return std::string(value::name(reason));
    const auto code = value::status_code(reason);
    return fmt::format("exception {}", code >= 256 ? code - 256 : code);
}

std::string error_line(std::string_view code, std::string_view text) {
    return fmt::format("error {} {}\n", code, text::escape_line(text));
}

std::string error_line(const Texts& texts, const Error& error) {
    return error_line(name(error.code), texts.describe(error));
}

std::string not_written_text(const Texts& texts, const host::Configuration& configuration,
                             const host::Outcome& outcome) {
    const auto* const variable = configuration.variable_of(outcome.slot);
    if (outcome.progress != host::Outcome::Progress::not_written || variable == nullptr) return {};
    const auto& trigger = variable->write_trigger;
    Texts::Arguments arguments{{"name", variable->name},
                               {"value", configuration.value_text(outcome.slot, outcome.value)}};
    if (!trigger) return texts("command.not_written", arguments);
    arguments.emplace_back("trigger", configuration.project().locals[*trigger].name);
    return texts("command.not_written.trigger", arguments);
}

std::string outcome_line(const Texts& texts, const host::Configuration& configuration,
                         const host::Outcome& outcome) {
    if (outcome.error) return error_line(texts, *outcome.error);
    if (outcome.kind == Command::Kind::get)
        return text::escape_line(get_line(get_json(configuration, outcome))) + '\n';
    const ValueTexts values(configuration, outcome);
    std::string line =
        is_acknowledged(outcome) ? acknowledged_line(values, outcome) : result_line(values, outcome);
    if (outcome.rounded) line += " rounded";
    if (outcome.not_retained) line += " not_retained";
    if (const auto text = not_written_text(texts, configuration, outcome); !text.empty()) line += ": " + text;
    return text::escape_line(line) + '\n';
}

file::Json error_json(const Texts& texts, const Error& error, std::string_view command,
                      std::string_view name) {
    auto object = file::Json::object();
    object.set("event", "error");
    if (!command.empty()) object.set("command", command);
    if (!name.empty()) object.set("name", name);
    object.set("code", takt::name(error.code));
    object.set("text", texts.describe(error));
    return object;
}

file::Json outcome_json(const Texts& texts, const host::Configuration& configuration,
                        const host::Outcome& outcome) {
    const auto info = info_of(configuration, outcome);
    if (outcome.error) return error_json(texts, *outcome.error, command_word(outcome.kind), info.name);
    const ValueTexts values(configuration, outcome);
    const bool acknowledged = is_acknowledged(outcome);
    auto object = file::Json::object();
    const auto set_known = [&object](const char* key, const std::string& text) {
        if (!text.empty()) object.set(key, text);
    };
    object.set("event", acknowledged ? "answer" : "outcome");
    object.set("command", command_word(outcome.kind));
    if (outcome.id > 0) object.set("id", outcome.id);
    if (!acknowledged) {
        const auto* const line = configuration.line_of(outcome.slot);
        if (line) object.set("line", line->name);
        if (line) object.set("device", configuration.device_of(outcome.slot)->name);
    }
    object.set("name", info.name);
    if (acknowledged) {
        set_known("value", values.value);
        if (!outcome.service) set_known("words", configuration.value_words(outcome.slot, outcome.value));
        set_known("utc", utc_text(info, outcome.value));
        if (outcome.quality != value::Quality::good) object.set("quality", value::name(outcome.quality));
        set_known("reason", reason_word(outcome.reason));
        if (const auto progress = progress_word(outcome.progress); !progress.empty())
            object.set(std::string(progress), true);
        set_known("text", not_written_text(texts, configuration, outcome));
    } else {
        object.set("outcome", value::name(outcome.result));
        object.set("reason", reason_word(outcome.reason));
        set_known("wanted", values.value);
        set_known("written", values.written);
        set_known("read", values.read_back);
    }
    if (outcome.rounded) object.set("rounded", true);
    if (outcome.not_retained) object.set("retained", false);
    return object;
}

std::string quit_line() {
    return "ok\n";
}

file::Json quit_json() {
    auto object = file::Json::object();
    object.set("event", "answer");
    object.set("command", "quit");
    return object;
}

}  // namespace takt::report
