// What the program says to its user: messages by their stable code, in English, Russian and Ukrainian.
//
// The texts stand in src/text/po/*.po (msgid: the code; msgstr: the text with {named} placeholders) and are
// compiled in. The language is chosen per call; there is no process-wide state, everything here may be called
// from any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/text/language.hpp"

namespace takt::text {

/// What stands in a message for {name}.
struct Argument {
    std::string_view name;
    std::string_view text;
};

/// The text of `code`, each {name} replaced by its argument; a placeholder without an argument stays as it
/// is. Falls back to the English text, and for an unknown code to the code with its arguments: `field.odd
/// (value: 7, allowed: 0..5)`.
[[nodiscard]] std::string message(Language language, std::string_view code,
                                  std::span<const Argument> arguments = {});

/// Whether that very language has a text for the code.
[[nodiscard]] bool has(Language language, std::string_view code);

/// The text of a code with its placeholders, in that very language; empty when there is none.
[[nodiscard]] std::string_view pattern(Language language, std::string_view code);

/// Every code the language has a text for, in bytewise order.
[[nodiscard]] std::vector<std::string_view> codes(Language language);

/// What happened, in one sentence without a full stop: `/dev/ttyUSB0: cannot be opened: permission denied`.
/// Negative error numbers are those of name resolution (getaddrinfo), zero is none.
[[nodiscard]] std::string what(Language language, const Error& error);

/// What to do about it; empty where there is nothing to say.
[[nodiscard]] std::string advice(Language language, const Error& error);

/// Both: `what. advice`, or what() alone.
[[nodiscard]] std::string describe(Language language, const Error& error);

}  // namespace takt::text
