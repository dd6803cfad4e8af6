// The program without its main(), so that tests can run commands in their own process.
#pragma once

namespace takt::app {

/// Runs the command that the arguments name, as the program does.
/// @param argv  the program's name, then its arguments
/// @returns the exit code
int run_program(int argc, char** argv);

}  // namespace takt::app
