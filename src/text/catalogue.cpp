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

// The cardinal plural rules of Unicode CLDR for whole numbers. Of "1..3" the last number counts.
std::size_t plural_form(Language language, std::string_view number) {
    const auto last_but = [&](std::size_t i) {
        const char c = number.size() > i ? number[number.size() - 1 - i] : '0';
        return c >= '0' && c <= '9' ? c - '0' : 0;
    };
    if (language == Language::english) return number == "1" ? 0 : 1;
    const int ones = last_but(0);
    if (last_but(1) == 1 || ones == 0 || ones > 4) return 2;
    return ones == 1 ? 0 : 1;
}

// Of "one|few|many".
std::string_view form_at(std::string_view forms, std::size_t index) {
    for (; index > 0 && forms.find('|') != std::string_view::npos; --index)
        forms.remove_prefix(forms.find('|') + 1);
    return forms.substr(0, forms.find('|'));
}

// In one pass, so that braces inside an argument are never taken for placeholders.
std::string fill(Language language, std::string_view pattern, std::span<const Argument> arguments) {
    std::string text;
    while (!pattern.empty()) {
        const auto open = pattern.find('{');
        text += pattern.substr(0, open);
        if (open == std::string_view::npos) break;
        pattern.remove_prefix(open + 1);
        const auto end = std::min(pattern.find_first_not_of(kNameCharacters), pattern.size());
        const char mark = end < pattern.size() ? pattern[end] : '\0';
        const auto close = mark == '|' ? pattern.find('}', end) : end;
        const bool named = mark == '}' || (mark == '|' && close != std::string_view::npos);
        const auto* argument = named ? find(arguments, pattern.substr(0, end)) : nullptr;
        if (!argument) {
            text += '{';
            continue;
        }
        if (mark == '}')
            text += escape_line(argument->text);
        else
            text += form_at(pattern.substr(end + 1, close - end - 1), plural_form(language, argument->text));
        pattern.remove_prefix(close + 1);
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
        if (const auto text = pattern(candidate, code); !text.empty())
            return fill(candidate, text, arguments);
    return bare(code, arguments);
}

std::vector<std::string_view> codes(Language language) {
    std::vector<std::string_view> result;
    for (const auto& entry : entries())
        if (!entry.texts[static_cast<std::size_t>(language)].empty()) result.push_back(entry.code);
    return result;
}

}  // namespace takt::text
