// Messages to the user by their stable code, in English, Russian and Ukrainian.
//
// The texts are in src/text/po/*.po (msgid: the code; msgstr: the text with {named} placeholders) and are
// compiled in. The language is chosen per call. There is no process-wide state; every function may be called
// from any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/text/language.hpp"

namespace takt::text {

/// The value of the placeholder {name}.
struct Argument {
    std::string_view name;
    std::string_view text;
};

/// The text of `code` with each {name} replaced by its argument, and each {name|one|few|many} by the plural
/// form for it (English has two); placeholders without an argument stay. Falls back to English, and for an
/// unknown code to the code with its arguments: `field.odd (value: 7, allowed: 0..5)`.
[[nodiscard]] std::string message(Language language, std::string_view code,
                                  std::span<const Argument> arguments = {});

/// Whether that language itself has a text for the code.
[[nodiscard]] bool has(Language language, std::string_view code);

/// The text of a code with its placeholders, in that language itself; empty if there is none.
[[nodiscard]] std::string_view pattern(Language language, std::string_view code);

/// Every code the language has a text for, in bytewise order.
[[nodiscard]] std::vector<std::string_view> codes(Language language);

/// The error in one sentence without a full stop: `/dev/ttyUSB0: cannot be opened: permission denied`.
/// Negative error numbers are those of getaddrinfo(); zero is none.
[[nodiscard]] std::string what(Language language, const Error& error);

/// The remedy; empty if there is none.
[[nodiscard]] std::string advice(Language language, const Error& error);

/// Both, as `what. advice`, or what() alone.
[[nodiscard]] std::string describe(Language language, const Error& error);

}  // namespace takt::text
