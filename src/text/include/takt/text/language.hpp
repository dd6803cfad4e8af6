// The languages of the messages and their selection.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace takt::text {

enum class Language : std::uint8_t { english, russian, ukrainian };

inline constexpr std::array kLanguages{Language::english, Language::russian, Language::ukrainian};

/// "en", "ru", "uk": the values of --lang and the names of the catalogues.
std::string_view tag(Language language);

/// The language that a tag or locale name begins with, in any case: "ru", "ru_RU.UTF-8", "uk-UA", "en";
/// nothing for others.
std::optional<Language> language(std::string_view tag);

/// Environment variables; empty if not set.
struct Environment {
    std::string_view language;     ///< LANGUAGE: a list with colons
    std::string_view lc_all;       ///< LC_ALL
    std::string_view lc_messages;  ///< LC_MESSAGES
    std::string_view lang;         ///< LANG
};

/// Selects the language as gettext does. The first of LC_ALL, LC_MESSAGES and LANG that is set names the
/// locale. Unless that is "C" or "POSIX", the first known language of LANGUAGE takes precedence. English if
/// nothing fits.
Language language(const Environment& environment);

}  // namespace takt::text
