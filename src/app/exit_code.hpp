// Exit codes of the program (docs/commands/README.md).
#pragma once

#include "takt/base/result.hpp"
#include "texts.hpp"

namespace takt::app {

enum class ExitCode : int {
    ok = 0,
    no = 1,     ///< the answer is no: findings, differences
    usage = 2,  ///< bad usage, or a project that cannot be read
    cannot_open = 3,
    timed_out = 4,
    exception = 5,  ///< the device refused
    bad_frame = 6,
    partly = 7,
};

/// The exit code an error ends the program with.
ExitCode exit_code(const Error& error);

/// The same, and prints what happened.
ExitCode ended_by(const Texts& texts, const Error& error);

/// Prints the error that ends the command. @returns `code`
ExitCode ended_with(const std::string& text, ExitCode code);

/// Reports output that could not be written. A closed pipe is no failure: its reader has read enough.
/// @returns the exit status of the program
[[nodiscard]] int end_status(text::Language language, ExitCode code);

/// Ends the process as the end of the program would, but destroys nothing: threads that are at work may still
/// use it.
[[noreturn]] void leave_program(text::Language language, ExitCode code);

}  // namespace takt::app
