// The program without its main(), so that tests can run commands in their own process.
#pragma once

#include "exit_code.hpp"
#include "takt/text/language.hpp"

namespace takt::app {

/// Runs the command that the arguments name, as the program does.
/// @param argv  the program's name, then its arguments
/// @returns the exit code
int run_program(int argc, char** argv);

/// Ends the process as the end of run_program() would, but destroys nothing: threads that are at work may
/// still use it.
[[noreturn]] void leave_program(text::Language language, ExitCode code);

}  // namespace takt::app
