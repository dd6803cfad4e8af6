// Times in files: 2026-11-21T17:03:20Z.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace takt::file {

using Seconds = std::chrono::sys_seconds;

[[nodiscard]] std::string time_text(Seconds time);
/// Nothing if the text has another form or names no existing time.
[[nodiscard]] std::optional<Seconds> time_of(std::string_view text);

}  // namespace takt::file
