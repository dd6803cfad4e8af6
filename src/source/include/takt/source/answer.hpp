// Measurements out of the bytes that somebody said. Pure; whatever the bytes, nothing but what fits the whole
// template or format becomes a value.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/model/source.hpp"
#include "takt/source/reading.hpp"

namespace takt::source {

inline constexpr std::size_t kMostAnswer = 1024;  ///< bytes of an answer
inline constexpr std::size_t kMostText = 4096;    ///< bytes of a file or of the output of a command

/// The measurements of a text that the template matches from its first to its last byte; nothing where it
/// does not. Numbers that are no finite number of their kind match nothing. Takes time in proportion to text
/// times template.
std::optional<Measurements> match(const model::TextTemplate& pattern, std::string_view text);

/// The measurements of a whole answer, its end bytes or checksum included; nothing where something differs.
std::optional<Measurements> read_answer(const model::AnswerFormat& format, Bytes answer);

/// What stands at the beginning of bytes that came.
struct Found {
    std::size_t skip = 0;    ///< bytes that can be no part of an answer
    std::size_t answer = 0;  ///< the answer behind them; 0: it is not complete
};

/// Looks for the first answer of that form, by its end or by its beginning and length.
Found find_answer(const model::AnswerFormat& format, Bytes bytes);

}  // namespace takt::source
