// Parses measurements from received bytes. Pure. Only bytes that match the whole template or format become
// values.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/endpoint/reading.hpp"
#include "takt/model/source.hpp"

namespace takt::endpoint {

inline constexpr std::size_t kMostAnswer = 1024;  ///< bytes of an answer
inline constexpr std::size_t kMostText = 4096;    ///< bytes of a file or of the output of a command

/// The measurements of a text that matches the template completely; nothing if it does not. A number that is
/// not finite or does not fit its kind is no match. Time is O(text * template).
std::optional<Measurements> match(const model::TextTemplate& pattern, std::string_view text);

/// The measurements of a whole answer, including its end bytes or checksum; nothing if any part differs.
std::optional<Measurements> read_answer(const model::AnswerFormat& format, Bytes answer);

/// The answer at the front of the received bytes.
struct Found {
    std::size_t skip = 0;    ///< leading bytes that belong to no answer
    std::size_t answer = 0;  ///< length of the answer behind them; 0: incomplete
};

/// Finds the first answer of that format, by its end bytes or by its beginning and length.
Found find_answer(const model::AnswerFormat& format, Bytes bytes);

}  // namespace takt::endpoint
