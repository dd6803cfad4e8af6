// What the ports of this operating system do to a line's times.
#pragma once

#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"

namespace takt::line {

/// Fits a master's settings to the real line it will work on; of no effect but on serial ports.
///
/// - A pseudo-terminal never echoes, and the response is there before the request would have been sent:
/// echoes
///   are not looked for.
/// - Bytes reach the program in lumps (UART buffers, USB packets, a busy processor), with pauses between them
///   that were not on the line. Where config.frame_silence is zero it becomes t3.5 + 8 ms, or a response that
///   came in one piece would now and then be taken apart. It costs time only behind a broken response: the
///   silence before a request stays what it is.
[[nodiscard]] bus::LineConfig fit_to_real_line(bus::LineConfig config, const model::Line& line);

}  // namespace takt::line
