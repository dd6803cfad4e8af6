#include "takt/console/session_commands.hpp"

#include <utility>

#include "takt/console/clock_text.hpp"
#include "takt/report/command_report.hpp"
#include "takt/report/outputs_report.hpp"
#include "takt/report/state_report.hpp"
#include "takt/value/text.hpp"

namespace takt::console {
namespace {

constexpr std::string_view verb_word(ControlCommand::Verb verb) {
    switch (verb) {
        case ControlCommand::Verb::set: return "set";
        case ControlCommand::Verb::write: return "write";
        case ControlCommand::Verb::get: return "get";
        case ControlCommand::Verb::status: return "status";
        case ControlCommand::Verb::list: return "list";
        case ControlCommand::Verb::values: return "values";
        case ControlCommand::Verb::quit: return "quit";
    }
    return "";
}

constexpr bool asks_for_state(ControlCommand::Verb verb) {
    return verb == ControlCommand::Verb::status || verb == ControlCommand::Verb::list ||
           verb == ControlCommand::Verb::values;
}

constexpr host::Command::Kind kind_of(ControlCommand::Verb verb) {
    switch (verb) {
        case ControlCommand::Verb::set: return host::Command::Kind::set;
        case ControlCommand::Verb::write: return host::Command::Kind::write;
        default: return host::Command::Kind::get;
    }
}

// One that the project does not use has no slot.
Result<host::Command> service_command(const host::Configuration& configuration,
                                      const ControlCommand& command) {
    const auto service = model::ServiceNames(configuration.project()).find(command.name);
    if (!service) return fail(Code::not_found, command.name);
    return host::Command{.kind = kind_of(command.verb), .service = service};
}

Answer refused(const Texts& texts, const host::Configuration& configuration, const ControlCommand& command,
               const Error& error) {
    const auto verb = verb_word(command.verb);
    const bool of_service = command.name == "system" || model::resembles_service_name(command.name);
    if (error.code != Code::not_found || !of_service)
        return {report::error_line(texts, error), report::error_json(texts, error, verb, command.name)};
    const auto hint = model::ServiceNames(configuration.project()).hint(command.name);
    const auto text = texts("console.service_unknown",
                            {{"name", command.name}, {"nearest", hint.nearest}, {"allowed", hint.allowed}});
    auto object = report::error_json(texts, error, verb, command.name);
    object.set("text", text);
    return {report::error_line(name(error.code), text), object};
}

Result<host::Command> host_command(const host::Configuration& configuration, const ControlCommand& command) {
    const auto slot = configuration.find(command.name);
    if (!slot) return service_command(configuration, command);
    host::Command result{.kind = kind_of(command.verb), .slot = *slot, .value = {}};
    if (result.kind == host::Command::Kind::get || configuration.info(*slot).service) return result;
    const auto& info = configuration.info(*slot);
    TAKT_TRY(result.value, value::parse(info.type, info.scaled, command.value));
    return result;
}

}  // namespace

SessionCommands::SessionCommands(host::Session& session, const Texts& texts, std::function<void()> quit,
                                 TakeSnapshot snapshot)
    : session_(session), texts_(texts), quit_(std::move(quit)), snapshot_(std::move(snapshot)) {
    if (!snapshot_) snapshot_ = [this](const host::SnapshotParts& parts) { return session_.snapshot(parts); };
}

// A line of JSON in both forms: the answer to a command is one line.
Result<Answer> SessionCommands::state(const ControlCommand& command) const {
    const bool all = command.verb != ControlCommand::Verb::list;
    TAKT_TRY(const auto now, snapshot_({.values = all, .statistics = all}));
    const auto time = iso_time(now.t);
    auto json = command.verb == ControlCommand::Verb::status ? report::status_json(texts_, now, time)
                : all                                        ? report::values_json(now, time, command.name)
                                                             : report::list_json(*now.configuration);
    if (command.verb == ControlCommand::Verb::status && outputs_)
        report::add_outputs(texts_, json, outputs_(), wall_ns(now.t));
    auto line = json.dump() + '\n';
    return Answer{.line = std::move(line), .json = std::move(json)};
}

Result<void> SessionCommands::execute(const std::string& line, const Reply& reply) {
    TAKT_TRY(const auto command, parse_control(line));
    if (command.verb == ControlCommand::Verb::quit) {
        reply(quit_answer());
        quit_();
        return {};
    }
    if (asks_for_state(command.verb)) {
        TAKT_TRY(const auto answer, state(command));
        reply(answer);
        return {};
    }
    const auto configuration = session_.configuration();
    auto given = host_command(*configuration, command);
    if (given) given->tag = ++last_tag_;
    const auto submitted =
        given ? session_.submit(*given) : Result<host::CommandId>(std::unexpected(given.error()));
    if (!submitted) {
        reply(refused(texts_, *configuration, command, submitted.error()));
        return {};
    }
    waiting_.emplace(last_tag_, Waiting{reply, configuration});
    return {};
}

void SessionCommands::take_outcomes() {
    while (const auto outcome = session_.next_outcome()) {
        const auto waiting = waiting_.extract(outcome->tag);
        if (waiting.empty()) continue;
        const auto& configuration = *waiting.mapped().configuration;
        const bool got = outcome->kind == host::Command::Kind::get && !outcome->error;
        waiting.mapped().reply({report::outcome_line(texts_, configuration, *outcome),
                                report::outcome_json(texts_, configuration, *outcome),
                                got ? report::get_json(configuration, *outcome) : file::Json()});
    }
}

}  // namespace takt::console
