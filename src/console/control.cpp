#include "takt/console/control.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "takt/base/ascii.hpp"
#include "takt/value/text.hpp"

namespace takt::console {
namespace {

std::unexpected<Error> wrong_syntax(std::string_view part, std::string_view right) {
    return fail(Code::syntax, value::beside_allowed(part, right));
}

/// Takes the first word, or the first text in double quotes, off `rest`.
Result<std::string> take_control_word(std::string_view& rest) {
    rest = trimmed(rest, kCommandBlanks);
    if (rest.starts_with('"')) {
        const auto end = rest.find('"', 1);
        if (end == std::string_view::npos) return wrong_syntax(rest, "\"…\"");
        std::string word(rest.substr(1, end - 1));
        rest = trimmed(rest.substr(end + 1), kCommandBlanks);
        return word;
    }
    const auto end = std::min(rest.find_first_of(kCommandBlanks), rest.size());
    std::string word(rest.substr(0, end));
    rest = trimmed(rest.substr(end), kCommandBlanks);
    return word;
}

/// The words that a command takes behind its verb.
enum class Words : std::uint8_t { none, pattern, name, name_and_value };

struct KnownVerb {
    std::string_view word;
    ControlCommand::Verb verb;
    Words words;
};

constexpr std::array kVerbs{
    KnownVerb{"set", ControlCommand::Verb::set, Words::name_and_value},
    KnownVerb{"write", ControlCommand::Verb::write, Words::name_and_value},
    KnownVerb{"get", ControlCommand::Verb::get, Words::name},
    KnownVerb{"status", ControlCommand::Verb::status, Words::none},
    KnownVerb{"list", ControlCommand::Verb::list, Words::none},
    KnownVerb{"values", ControlCommand::Verb::values, Words::pattern},
    KnownVerb{"quit", ControlCommand::Verb::quit, Words::none},
};

}  // namespace

Result<ControlCommand> parse_control(std::string_view line) {
    std::string_view rest = line;
    TAKT_TRY(const std::string word, take_control_word(rest));
    const auto* known = std::ranges::find(kVerbs, word, &KnownVerb::word);
    if (word.empty()) return wrong_syntax(line, kControlUsage);
    if (known == kVerbs.end()) return fail(Code::not_found, word);
    ControlCommand command{known->verb, {}, {}};
    if (known->words != Words::none) {
        TAKT_TRY(command.name, take_control_word(rest));
        if (command.name.empty() && known->words != Words::pattern) return wrong_syntax(line, kControlUsage);
    }
    const bool takes_value = known->words == Words::name_and_value;
    if (takes_value == rest.empty()) return wrong_syntax(line, kControlUsage);
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
