#include "takt/console/control.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "takt/base/ascii.hpp"
#include "takt/value/text.hpp"

namespace takt::console {
namespace {

constexpr std::string_view kBlanks = " \t\r";

constexpr std::string_view kUsage = "set NAME VALUE, write NAME VALUE, get NAME, quit";

std::unexpected<Error> wrong(std::string_view part, std::string_view right) {
    return fail(Code::syntax, value::beside_allowed(part, right));
}

/// Takes the first word, or the first text in double quotes, off `rest`.
Result<std::string> take_word(std::string_view& rest) {
    rest = trimmed(rest, kBlanks);
    if (rest.starts_with('"')) {
        const auto end = rest.find('"', 1);
        if (end == std::string_view::npos) return wrong(rest, "\"…\"");
        std::string word(rest.substr(1, end - 1));
        rest = trimmed(rest.substr(end + 1), kBlanks);
        return word;
    }
    const auto end = std::min(rest.find_first_of(kBlanks), rest.size());
    std::string word(rest.substr(0, end));
    rest = trimmed(rest.substr(end), kBlanks);
    return word;
}

constexpr std::array<std::pair<std::string_view, ControlCommand::Verb>, 4> kVerbs{{
    {"set", ControlCommand::Verb::set},
    {"write", ControlCommand::Verb::write},
    {"get", ControlCommand::Verb::get},
    {"quit", ControlCommand::Verb::quit},
}};

}  // namespace

Result<ControlCommand> parse_control(std::string_view line) {
    std::string_view rest = line;
    TAKT_TRY(const std::string word, take_word(rest));
    const auto* known =
        std::find_if(kVerbs.begin(), kVerbs.end(), [&](const auto& verb) { return verb.first == word; });
    if (known == kVerbs.end()) return wrong(word, kUsage);
    ControlCommand command{known->second, {}, {}};
    if (command.verb != ControlCommand::Verb::quit) {
        TAKT_TRY(command.name, take_word(rest));
        if (command.name.empty()) return wrong(line, kUsage);
    }
    const bool takes_value =
        command.verb == ControlCommand::Verb::set || command.verb == ControlCommand::Verb::write;
    if (takes_value == rest.empty()) return wrong(line, kUsage);
    command.value = rest;
    return command;
}

void LineSplitter::feed(std::string_view bytes, const std::function<void(Result<std::string>)>& on_line) {
    for (const char byte : bytes) {
        if (byte == '\n') {
            if (!skipping_) on_line(std::exchange(line_, {}));
            skipping_ = false;
        } else if (!skipping_) {
            line_ += byte;
            if (line_.size() > kMaxLine) {
                skipping_ = true;
                line_.clear();
                on_line(fail(Code::too_long, static_cast<std::int64_t>(kMaxLine) + 1, kMaxLine));
            }
        }
    }
}

std::string LineSplitter::end() {
    skipping_ = false;
    return std::exchange(line_, {});
}

}  // namespace takt::console
