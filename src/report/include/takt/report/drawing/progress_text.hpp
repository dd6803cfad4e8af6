// The progress of a long command as text.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "takt/base/time.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// How much is done, of how much, in the same unit; `total` may grow. 0, without `requests`: unknown, no
/// share is shown.
struct Done {
    std::size_t done = 0;
    std::size_t total = 0;
    std::optional<std::size_t> requests = {};  ///< sent so far: reported as a rate; nothing: not counted
};

/// "[#####-----]" with `width` characters between the brackets.
[[nodiscard]] std::string progress_bar(std::size_t done, std::size_t total, std::size_t width);

/// The share done in percent, and if requests are counted, their rate and the remaining time at that pace.
/// @param what  the current step, in words
[[nodiscard]] std::string progress_line(const Texts& texts, const Done& done, Duration elapsed,
                                        const std::string& what);

/// The line behind a bar, which takes what is left of the columns of a terminal: 6 to 24 characters. The last
/// column stays empty.
/// @param columns  at least 1
[[nodiscard]] std::string progress_with_bar(const Texts& texts, const Done& done, Duration elapsed,
                                            const std::string& what, std::size_t columns);

}  // namespace takt::report
