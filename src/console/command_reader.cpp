#include "takt/console/command_reader.hpp"

#include <algorithm>
#include <vector>

#include "takt/base/ascii.hpp"
#include "takt/model/nearest.hpp"
#include "takt/report/states/command_report.hpp"

namespace takt::console {
namespace {

constexpr std::string_view kJson = "--json";
constexpr std::string_view kLanguage = "--lang";

/// Takes `option` off the beginning of a line. @returns false: it does not begin so
bool take_option(std::string_view option, std::string& line) {
    const std::string_view text = trimmed(line, kCommandBlanks);
    if (!text.starts_with(option)) return false;
    const std::string_view rest = text.substr(option.size());
    if (rest.empty() || kCommandBlanks.find(rest.front()) == std::string_view::npos) return false;
    line = trimmed(rest, kCommandBlanks);
    return true;
}

/// Takes `--lang TAG` off the beginning of a line.
Texts take_language(std::string& line, const Texts& otherwise) {
    if (!take_option(kLanguage, line)) return otherwise;
    const auto end = std::min(line.find_first_of(kCommandBlanks), line.size());
    const auto language = text::language(line.substr(0, end));
    line = trimmed(std::string_view(line).substr(end), kCommandBlanks);
    return language ? Texts(*language) : otherwise;
}

Reply as_json(const Reply& reply) {
    return [reply](const Answer& answer) {
        const auto& data = answer.data.is_null() ? answer.json : answer.data;
        reply({.line = data.dump() + '\n', .json = data});
    };
}

}  // namespace

Answer error_answer(const Texts& texts, const Error& error) {
    return error_answer(texts, error, texts.describe(error));
}

Answer error_answer(const Texts& texts, const Error& error, std::string_view text, std::string_view command,
                    std::string_view name) {
    auto object = report::error_json(texts, error, command, name);
    object.set("text", text);
    return {report::error_line(takt::name(error.code), text), object};
}

Answer unknown_command(const Texts& texts, std::string_view word, std::string_view usage) {
    std::vector<std::string_view> verbs;
    for (auto rest = usage; !rest.empty();) {
        verbs.push_back(rest.substr(0, rest.find_first_of(", ")));
        const auto comma = std::min(rest.find(", "), rest.size() - 1);
        rest.remove_prefix(std::min(comma + 2, rest.size()));
    }
    const auto nearest = model::nearest(word, verbs);
    const bool unlike = model::is_unlike(word, nearest);
    const auto text = texts(
        unlike ? "console.command_unlike" : "console.command_unknown",
        {{"word", std::string(word)}, {"nearest", std::string(nearest)}, {"allowed", std::string(usage)}});
    return error_answer(texts, fail(Code::syntax, word).error(), text);
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
    const Texts texts = line ? take_language(*line, texts_) : texts_;
    const Reply reply = line && take_option(kJson, *line) ? as_json(asked) : asked;
    const auto done = line ? execute_(*line, reply, texts) : Result<void>(std::unexpected(line.error()));
    if (!done) reply(error_answer(texts, done.error()));
    return true;
}

}  // namespace takt::console
