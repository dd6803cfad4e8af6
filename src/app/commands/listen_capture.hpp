#pragma once

#include "commands/listen_command.hpp"
#include "exit_code.hpp"
#include "texts.hpp"

namespace takt::app {

/// `takt listen FILE`: the serial frames of a capture, of the first line that has some.
[[nodiscard]] ExitCode listen_to_capture(const Texts& texts, const ListenOptions& options);

}  // namespace takt::app
