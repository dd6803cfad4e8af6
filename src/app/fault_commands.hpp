// Faults switched while a slave answers.
#pragma once

#include <memory>

#include "takt/app/control_server.hpp"
#include "takt/line/loop.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::app {

/// `fault add FAULT`, `fault clear`, `fault list` (both are answered with the rules in force), and `quit`,
/// which stops the loop. @returns syntax; queue_full
[[nodiscard]] Execute fault_commands(line::Loop& loop, std::shared_ptr<sim::AnswerFaults> faults);

}  // namespace takt::app
