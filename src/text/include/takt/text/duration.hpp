// Durations for people: tables, messages, pictures and the page have the same digits and units.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/time.hpp"
#include "takt/text/language.hpp"

namespace takt::text {

/// Three significant digits, and whole milliseconds: "7.50 µs", "0.85 ms", "12.3 ms", "1503 ms"; whole
/// seconds as "2 s"; "12.3 s" from 10 s on, "3 min 20 s" and "26 h 5 min" from a minute on. Halves are
/// rounded up. The page has the same rules (ui/src/i18n/index.ts).
[[nodiscard]] std::string duration_text(Language language, Duration duration);

/// The least duration from this one on that duration_text() shows as it is. Of bounds, which are never shown
/// smaller than they are: 60.525 s is "1 min 1 s", 12.31 ms is "12.4 ms".
[[nodiscard]] Duration rounded_up(Duration duration);

/// "117.721 мс" of "117.721 ms", the exact times of findings. Other texts stay as they are.
[[nodiscard]] std::string with_local_unit(Language language, std::string_view text);

}  // namespace takt::text
