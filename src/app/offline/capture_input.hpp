// The bytes of a capture, from a file or standard input.
#pragma once

#include <functional>
#include <string>

#include "takt/base/result.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/report/drawing/progress_text.hpp"

namespace takt::app {

/// Gives the reader a capture: to its end, to its first error, or until a signal comes or the standard output
/// is closed. See StoppableInput.
/// @param source  "-": standard input
/// @param show    called after each read, in bytes
/// @returns the errors of StoppableInput; those of the content are the reader's
Result<void> read_capture(const std::string& source, capture::CaptureReader& reader,
                          const std::function<void(const report::Done&)>& show);

}  // namespace takt::app
