// How a number stands in a text: what an instrument, a file or a command says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

namespace takt::model {

/// A text with places for measurements. `{name}` is a decimal number (blanks before it, a sign, a point, an
/// exponent), `{name:hex}` hexadecimal digits, `{name:text}` and `{*}` anything up to what follows them, the
/// latter without a name. Everything else stands for itself; `\r \n \t \0 \\ \{ \} \xHH` are characters.
struct TextTemplate {
    enum class Kind : std::uint8_t { literal, number, hex, text, skip };
    struct Piece {
        Kind kind = Kind::literal;
        std::string text;  ///< of a literal: its bytes; else the name
        friend bool operator==(const Piece&, const Piece&) = default;
    };
    std::vector<Piece> pieces;

    /// Whether a measurement has that name.
    [[nodiscard]] bool has(std::string_view name) const;
    [[nodiscard]] std::vector<std::string_view> names() const;
};

inline constexpr std::size_t kMostTemplateBytes = 256;
inline constexpr std::size_t kMostTemplatePieces = 64;

/// Where a template is wrong: the byte of its text, counted from 1.
struct TemplateError {
    std::size_t position = 0;
};

/// @returns an error for an escape or a brace that is none of the above, a name that is not one of letters,
/// digits and `_` or stands there twice, two places side by side of which the first has no end, and beyond
/// the limits
std::expected<TextTemplate, TemplateError> parse_template(std::string_view text);

/// Text with the escapes of a template and no places: what is sent to an instrument.
std::expected<std::string, TemplateError> parse_bytes(std::string_view text);

}  // namespace takt::model
