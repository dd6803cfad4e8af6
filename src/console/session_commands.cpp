#include "takt/console/session_commands.hpp"

#include <utility>

#include "takt/report/command_report.hpp"
#include "takt/value/text.hpp"

namespace takt::console {
namespace {

constexpr std::string_view word(ControlCommand::Verb verb) {
    switch (verb) {
        case ControlCommand::Verb::set: return "set";
        case ControlCommand::Verb::write: return "write";
        case ControlCommand::Verb::get: return "get";
        case ControlCommand::Verb::quit: return "quit";
    }
    return "";
}

constexpr host::Command::Kind kind_of(ControlCommand::Verb verb) {
    switch (verb) {
        case ControlCommand::Verb::set: return host::Command::Kind::set;
        case ControlCommand::Verb::write: return host::Command::Kind::write;
        default: return host::Command::Kind::get;
    }
}

}  // namespace

Result<host::Command> SessionCommands::host_command(const ControlCommand& command) const {
    const auto& configuration = *session_.configuration();
    const auto slot = configuration.find(command.name);
    if (!slot) return fail(Code::not_found, command.name);
    host::Command result{.kind = kind_of(command.verb), .slot = *slot, .value = {}};
    if (result.kind == host::Command::Kind::get) return result;
    const auto& info = configuration.info(*slot);
    TAKT_TRY(result.value, value::parse(info.type, info.scaled, command.value));
    return result;
}

Result<void> SessionCommands::execute(const std::string& line, const Reply& reply) {
    TAKT_TRY(const auto command, parse_control(line));
    if (command.verb == ControlCommand::Verb::quit) {
        reply(quit_answer());
        quit_();
        return {};
    }
    auto given = host_command(command);
    if (given) given->tag = ++last_tag_;
    const auto submitted =
        given ? session_.submit(*given) : Result<host::CommandId>(std::unexpected(given.error()));
    if (!submitted) {
        reply({report::error_line(texts_, submitted.error()),
               report::error_json(texts_, submitted.error(), word(command.verb), command.name)});
        return {};
    }
    waiting_.emplace(last_tag_, reply);
    return {};
}

void SessionCommands::take_outcomes() {
    while (const auto outcome = session_.next_outcome()) {
        const auto waiting = waiting_.extract(outcome->tag);
        if (waiting.empty()) continue;
        const auto& configuration = *session_.configuration();
        waiting.mapped()({report::outcome_line(texts_, configuration, *outcome),
                          report::outcome_json(texts_, configuration, *outcome)});
    }
}

}  // namespace takt::console
