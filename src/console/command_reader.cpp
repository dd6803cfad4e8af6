#include "takt/console/command_reader.hpp"

#include "takt/report/command_report.hpp"

namespace takt::console {

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

bool CommandReader::execute(const Result<std::string>& line, const Reply& reply) {
    if (line && line->find_first_not_of(" \t\r") == std::string::npos) return false;
    const auto done = line ? execute_(*line, reply) : Result<void>(std::unexpected(line.error()));
    if (!done) reply(error_answer(texts_, done.error()));
    return true;
}

}  // namespace takt::console
