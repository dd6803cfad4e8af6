// Moments in files, as text: 2026-11-21T17:03:20Z.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace takt::file {

using Seconds = std::chrono::sys_seconds;

[[nodiscard]] std::string time_text(Seconds time);
/// Nothing where it is not exactly of that form, or there is no such moment.
[[nodiscard]] std::optional<Seconds> time_of(std::string_view text);

}  // namespace takt::file
