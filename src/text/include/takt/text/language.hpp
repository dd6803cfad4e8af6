// The languages of the messages, and how one is chosen.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace takt::text {

enum class Language : std::uint8_t { english, russian, ukrainian };

inline constexpr std::array kLanguages{Language::english, Language::russian, Language::ukrainian};

/// "en", "ru", "uk": as --lang takes it and as the catalogues are named.
std::string_view tag(Language language);

/// The language a tag or a locale's name begins with, in any case: "ru", "ru_RU.UTF-8", "uk-UA", "en";
/// nullopt for others.
std::optional<Language> language(std::string_view tag);

/// The values of the environment variables of the same names; empty where they are not set.
struct Environment {
    std::string_view language;     ///< LANGUAGE: a list with colons
    std::string_view lc_all;       ///< LC_ALL
    std::string_view lc_messages;  ///< LC_MESSAGES
    std::string_view lang;         ///< LANG
};

/// The language gettext would take of the three: the first of LC_ALL, LC_MESSAGES and LANG that is set names
/// the locale; unless that is "C" or "POSIX", the first known language of LANGUAGE goes before it. English
/// when nothing fits.
Language language(const Environment& environment);

}  // namespace takt::text
