#pragma once

#include <string>
#include <string_view>

#include "takt/text/language.hpp"

namespace takt::text {

/// The words of module wire for a frame in a language: "unit 16 read coils 0..1 → 2 values: 0 1" as
/// "адрес 16 чтение дискретных выходов 0..1 → 2 значения: 0 1". Its phrases are the messages `frame.*` and
/// `exception.*`. Texts in quotes come from devices and stay as they are.
[[nodiscard]] std::string frame_text(Language language, std::string_view words);

}  // namespace takt::text
