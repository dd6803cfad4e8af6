#include "takt/text/language.hpp"

#include <algorithm>
#include <cctype>
#include <ranges>
#include <string>

namespace takt::text {
namespace {

// "ru_RU.UTF-8@x" -> "ru"
std::string first_part(std::string_view locale) {
    std::string part(locale.substr(0, locale.find_first_of("_-.@")));
    std::ranges::transform(part, part.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return part;
}

}  // namespace

std::string_view tag(Language language) {
    switch (language) {
        case Language::english: return "en";
        case Language::russian: return "ru";
        case Language::ukrainian: return "uk";
    }
    return "en";
}

std::optional<Language> language(std::string_view tag_or_locale) {
    const auto part = first_part(tag_or_locale);
    for (const auto candidate : kLanguages)
        if (tag(candidate) == part) return candidate;
    return std::nullopt;
}

Language language(const Environment& environment) {
    std::string_view locale;
    for (const auto value : {environment.lc_all, environment.lc_messages, environment.lang})
        if (locale.empty()) locale = value;
    const auto part = first_part(locale);
    if (part.empty() || part == "c" || part == "posix") return Language::english;
    for (const auto wish : std::views::split(environment.language, ':'))
        if (const auto known = language(std::string_view(wish.begin(), wish.end()))) return *known;
    return language(locale).value_or(Language::english);
}

}  // namespace takt::text
