// Findings about the guarantees of a plan (docs/guarantees.md, "The verdict").
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::plan {

/// Findings of each line, the worst first:
///   - variables whose response can be later than they allow, or is unbounded;
///   - overload;
///   - if nothing is late without failures: variables that are late under the project's `faults` or with the
///     worst dead device.
/// Late values are errors if the turnaround of every device of the line is known, if the variable or its
/// device has its own deadline, or with `prove`; else warnings. Lateness by failures is a warning. At most
/// ten findings of each kind per line (three warnings); the last one reports how many more there are.
///
/// Codes: guarantee.late, .unbounded (variable, device, response, deadline, over), .overload (line,
/// utilization), .late_with_fault, .late_with_dead (variable, device, response, deadline), .unlimited, .more
/// (line, count).
/// @param guarantees  of that plan
[[nodiscard]] std::vector<model::Finding> guarantee_findings(const model::Project& project, const Plan& plan,
                                                             std::span<const LineGuarantee> guarantees,
                                                             bool prove = false);

/// All codes of guarantee_findings(). Each has a message and, with ".advice", an advice in module `text`.
[[nodiscard]] std::span<const std::string_view> guarantee_finding_codes();

/// A time as in findings: "117.721 ms".
[[nodiscard]] std::string time_text(Duration time);

}  // namespace takt::plan
