#include "takt/console/session_commands.hpp"

#include <utility>
#include <vector>

#include "takt/console/clock_text.hpp"
#include "takt/model/nearest.hpp"
#include "takt/report/states/command_report.hpp"
#include "takt/report/states/outputs_report.hpp"
#include "takt/report/states/state_report.hpp"
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
    const auto answer = [&](std::string_view text) {
        return error_answer(texts, error, text, verb, command.name);
    };
    if (error.code != Code::not_found) return answer(texts.describe(error));
    if (!of_service) {
        std::vector<std::string_view> names;
        for (std::uint32_t id = 0; id < configuration.slots().size(); ++id)
            names.push_back(configuration.info({id}).name);
        const auto nearest = model::nearest(command.name, names);
        if (nearest.empty() || model::is_unlike(command.name, nearest))
            return answer(texts("console.name_unlike",
                                {{"name", command.name}, {"count", std::to_string(names.size())}}));
        return answer(
            texts("console.name_unknown", {{"name", command.name}, {"nearest", std::string(nearest)}}));
    }
    const auto hint = model::ServiceNames(configuration.project()).hint(command.name);
    return answer(texts("console.service_unknown",
                        {{"name", command.name}, {"nearest", hint.nearest}, {"allowed", hint.allowed}}));
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

SessionCommands::SessionCommands(host::Session& session, std::function<void()> quit, TakeSnapshot snapshot)
    : session_(session), quit_(std::move(quit)), snapshot_(std::move(snapshot)) {
    if (!snapshot_) snapshot_ = [this](const host::SnapshotParts& parts) { return session_.snapshot(parts); };
}

// A line of JSON in both forms: the answer to a command is one line.
Result<Answer> SessionCommands::state(const ControlCommand& command, const Texts& texts) const {
    const bool all = command.verb != ControlCommand::Verb::list;
    TAKT_TRY(const auto now, snapshot_({.values = all, .statistics = all}));
    const auto time = iso_time(now.t);
    auto json = command.verb == ControlCommand::Verb::status ? report::status_json(texts, now, time)
                : all                                        ? report::values_json(now, time, command.name)
                                                             : report::list_json(*now.configuration);
    if (command.verb == ControlCommand::Verb::status && outputs_)
        report::add_outputs(texts, json, outputs_(), wall_ns(now.t));
    auto line = json.dump() + '\n';
    return Answer{.line = std::move(line), .json = std::move(json)};
}

Result<void> SessionCommands::execute(const std::string& line, const Reply& reply, const Texts& texts) {
    const auto parsed = parse_control(line);
    if (!parsed && parsed.error().code == Code::not_found) {
        reply(unknown_command(texts, parsed.error().subject.view(), kControlUsage));
        return {};
    }
    TAKT_TRY(const auto command, parsed);
    if (command.verb == ControlCommand::Verb::quit) {
        reply(quit_answer());
        quit_();
        return {};
    }
    if (asks_for_state(command.verb)) {
        TAKT_TRY(const auto answer, state(command, texts));
        reply(answer);
        return {};
    }
    const auto configuration = session_.configuration();
    auto given = host_command(*configuration, command);
    if (given) given->tag = ++last_tag_;
    const auto submitted =
        given ? session_.submit(*given) : Result<host::CommandId>(std::unexpected(given.error()));
    if (!submitted) {
        reply(refused(texts, *configuration, command, submitted.error()));
        return {};
    }
    waiting_.emplace(last_tag_, Waiting{reply, configuration, texts});
    return {};
}

void SessionCommands::take_outcomes() {
    while (const auto outcome = session_.next_outcome()) {
        const auto waiting = waiting_.extract(outcome->tag);
        if (waiting.empty()) continue;
        const auto& configuration = *waiting.mapped().configuration;
        const auto& texts = waiting.mapped().texts;
        const bool got = outcome->kind == host::Command::Kind::get && !outcome->error;
        waiting.mapped().reply({report::outcome_line(texts, configuration, *outcome),
                                report::outcome_json(texts, configuration, *outcome),
                                got ? report::get_json(configuration, *outcome) : file::Json()});
    }
}

}  // namespace takt::console
