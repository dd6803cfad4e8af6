#include "takt/console/command_reader.hpp"

#include "takt/base/ascii.hpp"
#include "takt/report/command_report.hpp"

namespace takt::console {
namespace {

constexpr std::string_view kJson = "--json";

/// Takes `--json` off the beginning of a line. @returns false: it does not begin so
bool take_json(std::string& line) {
    const std::string_view text = trimmed(line, kCommandBlanks);
    if (!text.starts_with(kJson)) return false;
    const std::string_view rest = text.substr(kJson.size());
    if (rest.empty() || kCommandBlanks.find(rest.front()) == std::string_view::npos) return false;
    line = trimmed(rest, kCommandBlanks);
    return true;
}

Reply as_json(const Reply& reply) {
    return [reply](const Answer& answer) {
        const auto& data = answer.data.is_null() ? answer.json : answer.data;
        reply({.line = data.dump() + '\n', .json = data});
    };
}

}  // namespace

Answer error_answer(const Texts& texts, const Error& error) {
    return {report::error_line(texts, error), report::error_json(texts, error, {}, {})};
}

Answer quit_answer() {
    return {report::quit_line(), report::quit_json()};
}

std::size_t CommandReader::feed(std::string_view bytes, const Reply& reply) {
    std::size_t commands = 0;
    splitter_.feed(bytes,
                   [&](const Result<std::string>& line) { commands += execute(line, reply) ? 1U : 0U; });
    return commands;
}

std::size_t CommandReader::end(const Reply& reply) {
    const auto line = splitter_.end();
    return execute(line, reply) ? 1U : 0U;
}

bool CommandReader::execute(Result<std::string> line, const Reply& asked) {
    if (line && line->find_first_not_of(kCommandBlanks) == std::string::npos) return false;
    const Reply reply = line && take_json(*line) ? as_json(asked) : asked;
    const auto done = line ? execute_(*line, reply) : Result<void>(std::unexpected(line.error()));
    if (!done) reply(error_answer(texts_, done.error()));
    return true;
}

}  // namespace takt::console
