// The effect of this operating system's ports on a line.
#pragma once

#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"

namespace takt::line {

/// Adapts a master's settings to its real line.
/// - A pseudo-terminal has no byte times, so a response may arrive before the request would have been sent.
///   The echo of a repeated write then cannot be distinguished from the response by its time.
/// - A UART that collects characters, and cannot be set to hand on each one, delivers the end of a response
///   four characters late. Every deadline is later by that time.
/// - The transaction ids of Modbus TCP begin at random: a gateway may still answer requests of the run
/// before.
[[nodiscard]] bus::LineConfig fit_to_real_line(bus::LineConfig config, const model::Line& line);

}  // namespace takt::line
