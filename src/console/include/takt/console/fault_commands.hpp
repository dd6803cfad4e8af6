// Faults switched while a slave answers.
#pragma once

#include <functional>
#include <memory>

#include "takt/console/command_reader.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::console {

/// `fault add FAULT`, `fault clear`, `fault list` (both are answered with the rules in force), and `quit`.
/// @param now   the time of an `add`
/// @param quit  what `quit` does
/// The Execute returns syntax; queue_full.
[[nodiscard]] Execute fault_commands(std::shared_ptr<sim::AnswerFaults> faults, std::function<Instant()> now,
                                     std::function<void()> quit);

}  // namespace takt::console
