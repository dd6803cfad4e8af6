// The program's log: a rotated file behind spdlog, for maintainers.
#pragma once

#include <string>

#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/text/language.hpp"

namespace takt::app {

/// Begins logging to a file: rotated at 10 MB, three old ones kept, written by a thread of its own.
/// When the disk is full, lines are dropped and counted until there is space again.
/// @param level     trace, debug, info, warning, error
/// @param language  of lines that are texts of codes (Log::message())
/// @returns cannot_open, unsupported as os::RotatingFile::open()
[[nodiscard]] Result<void> begin_log(const std::string& path, const std::string& level,
                                     text::Language language = text::Language::english);

/// A module's handle to that log; silent before begin_log().
[[nodiscard]] Log log(std::string_view category);

/// Writes what is left; notes lost output (output.hpp) if the last lines could not be written.
void end_log();

}  // namespace takt::app
