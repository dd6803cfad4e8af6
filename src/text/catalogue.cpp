#include "takt/text/catalogue.hpp"

#include <algorithm>

#include "entry.hpp"
#include "takt/text/escape.hpp"

namespace takt::text {
namespace {

constexpr std::string_view kNameCharacters = "abcdefghijklmnopqrstuvwxyz0123456789_";

const Argument* find(std::span<const Argument> arguments, std::string_view name) {
    const auto found = std::ranges::find(arguments, name, &Argument::name);
    return found == arguments.end() ? nullptr : &*found;
}

// In one pass, so that braces inside an argument are never taken for placeholders.
std::string fill(std::string_view pattern, std::span<const Argument> arguments) {
    std::string text;
    while (!pattern.empty()) {
        const auto open = pattern.find('{');
        text += pattern.substr(0, open);
        if (open == std::string_view::npos) break;
        pattern.remove_prefix(open + 1);
        const auto end = std::min(pattern.find_first_not_of(kNameCharacters), pattern.size());
        const bool closed = end < pattern.size() && pattern[end] == '}';
        if (const auto* argument = closed ? find(arguments, pattern.substr(0, end)) : nullptr) {
            text += escape_line(argument->text);
            pattern.remove_prefix(end + 1);
        } else {
            text += '{';
        }
    }
    return text;
}

std::string bare(std::string_view code, std::span<const Argument> arguments) {
    std::string text(code);
    for (const auto& argument : arguments) {
        text += &argument == arguments.data() ? " (" : ", ";
        text.append(argument.name).append(": ").append(escape_line(argument.text));
    }
    if (!arguments.empty()) text += ')';
    return text;
}

}  // namespace

std::string_view pattern(Language language, std::string_view code) {
    const auto all = entries();
    const auto found = std::ranges::lower_bound(all, code, {}, &Entry::code);
    if (found == all.end() || found->code != code) return {};
    return found->texts[static_cast<std::size_t>(language)];
}

bool has(Language language, std::string_view code) {
    return !pattern(language, code).empty();
}

std::string message(Language language, std::string_view code, std::span<const Argument> arguments) {
    for (const auto candidate : {language, Language::english})
        if (const auto text = pattern(candidate, code); !text.empty()) return fill(text, arguments);
    return bare(code, arguments);
}

std::vector<std::string_view> codes(Language language) {
    std::vector<std::string_view> result;
    for (const auto& entry : entries())
        if (!entry.texts[static_cast<std::size_t>(language)].empty()) result.push_back(entry.code);
    return result;
}

}  // namespace takt::text
