// A serial line without a line: a pseudo-terminal, where bytes take no time.
#pragma once

#include <chrono>
#include <utility>

#include "load.hpp"

namespace bench {

/// Round trips of one request at a time over a pseudo-terminal: to the slave engine on its serial driver,
/// less the silence it keeps before an answer, and to a thread that sends as many bytes back at once.
/// @returns takt, echo
std::pair<Load, Load> measure_pty(std::chrono::milliseconds length);

}  // namespace bench
