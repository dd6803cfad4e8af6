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
    splitter_.feed(bytes, [&](Result<std::string> line) {
        if (line && line->find_first_not_of(" \t\r") == std::string::npos) return;
        ++commands;
        const auto done = line ? execute_(*line, reply) : Result<void>(std::unexpected(line.error()));
        if (done) return;
        reply(error_answer(texts_, done.error()));
    });
    return commands;
}

}  // namespace takt::console
