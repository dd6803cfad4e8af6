// Faults and values of simulated devices, switched while they answer.
#pragma once

#include <functional>
#include <memory>

#include "takt/console/command_reader.hpp"
#include "takt/console/served_devices.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::console {

/// `fault add [NAME:]FAULT`, `fault clear [NAME]`, `fault list` (all are answered with the rules in force),
/// `set NAME VALUE` and `get NAME` (answered with the value), and `quit`. A NAME is that of a device or, also
/// for values, of a variable.
/// @param now   the time of a command
/// @param quit  what `quit` does
/// The Execute returns syntax; queue_full; the errors of ServedDevices.
[[nodiscard]] Execute fault_commands(std::shared_ptr<sim::AnswerFaults> faults,
                                     std::shared_ptr<ServedDevices> devices, std::function<Instant()> now,
                                     std::function<void()> quit);

}  // namespace takt::console
