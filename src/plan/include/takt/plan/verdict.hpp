// What is wrong with the guarantees of a plan, as findings of its project (guarantees, "Verdict").
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::plan {

/// For each line, the worst first: every variable whose requests can be answered later than it allows, what
/// no bound holds for, more load than there is time, and, where nothing is late without them, what the
/// project's own `faults` or the worst dead device make late. Late values are errors where the turnaround of
/// every device of the line is known, where the variable or its device has a deadline of its own, and with
/// `prove`; else warnings; what failures do is a warning. At most ten findings of each kind a line (three
/// warnings), of which the last says how many more there are.
///
/// Codes: guarantee.late, .unbounded (variable, device, response, deadline, over), .overload (line,
/// utilization), .late_with_fault, .late_with_dead (variable, device, response, deadline), .unlimited,
/// .more (line, count).
/// @param guarantees  of that plan
[[nodiscard]] std::vector<model::Finding> verdict(const model::Project& project, const Plan& plan,
                                                  std::span<const LineGuarantee> guarantees,
                                                  bool prove = false);

/// Every code of verdict(): each has a message and, with ".advice", an advice in room `text`.
[[nodiscard]] std::span<const std::string_view> verdict_codes();

/// A time as findings tell it: "117.721 ms".
[[nodiscard]] std::string time_text(Duration time);

}  // namespace takt::plan
