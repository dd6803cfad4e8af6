// Templates that find numbers in texts of instruments, files and commands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

namespace takt::model {

/// A text with placeholders. `{name}` is a decimal number (leading blanks, sign, point, exponent),
/// `{name:hex}` a hexadecimal one. `{name:text}` is any text up to the next literal; `{*}` the same without a
/// name. Everything else is literal; `\r \n \t \0 \\ \{ \} \xHH` are escapes.
struct TextTemplate {
    enum class Kind : std::uint8_t { literal, number, hex, text, skip };
    struct Piece {
        Kind kind = Kind::literal;
        std::string text;  ///< of a literal: its bytes; else the name
        friend bool operator==(const Piece&, const Piece&) = default;
    };
    std::vector<Piece> pieces;
    friend bool operator==(const TextTemplate&, const TextTemplate&) = default;

    /// Whether a measurement has that name.
    [[nodiscard]] bool has(std::string_view name) const;
    [[nodiscard]] std::vector<std::string_view> names() const;
};

inline constexpr std::size_t kMostTemplateBytes = 256;
inline constexpr std::size_t kMostTemplatePieces = 64;

/// The error in a template: its byte offset, counted from 1.
struct TemplateError {
    std::size_t position = 0;
};

/// @returns an error for an unknown escape, an unbalanced brace, a name with other characters than letters,
///          digits and `_`, a duplicate name, two adjacent placeholders of which the first has no end, and
///          beyond the limits
std::expected<TextTemplate, TemplateError> parse_template(std::string_view text);

/// A literal text with the escapes of a template: a request to an instrument.
std::expected<std::string, TemplateError> parse_bytes(std::string_view text);

}  // namespace takt::model
