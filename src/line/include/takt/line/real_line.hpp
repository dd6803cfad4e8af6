// What the ports of this operating system do to a line's times.
#pragma once

#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"

namespace takt::line {

/// Fits a master's settings to the real line it will work on. Of effect on pseudo-terminals only: there a
/// response comes before the request would have been sent, so that the time of a repeated write cannot tell
/// the echo from the response.
[[nodiscard]] bus::LineConfig fit_to_real_line(bus::LineConfig config, const model::Line& line);

}  // namespace takt::line
