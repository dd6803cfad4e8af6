// Findings about the guarantees of a plan (docs/guarantees.md, "The verdict").
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::plan {

/// Whether the periods and deadlines of a line hold (docs/guarantees.md, "The verdict"), from the best
/// to the worst.
enum class Verdict : std::uint8_t {
    holds,             ///< every response is proved to be in time
    response_unknown,  ///< late only with the time-out of a device taken for its turnaround, which is not
                       ///< known
    not_proved,        ///< all turnarounds are known, and a response can be late
    cannot_hold,       ///< polling alone needs more time than the line has, or an explicit deadline is missed
};

/// "holds", "response_unknown", "not_proved", "cannot_hold"
[[nodiscard]] std::string_view name(Verdict verdict);

[[nodiscard]] Verdict verdict(const model::Project& project, const LinePlan& plan,
                              const LineGuarantee& guarantee);

/// Findings of each line, by its verdict:
///   - cannot_hold: an error for each late request with a deadline, or for the overload. In profile owen-kc1
///     an overload is a warning: its master polls such a line without pause;
///   - not_proved: a warning for each late request;
///   - response_unknown: one note;
///   - holds, all turnarounds known: a warning for each request that is late under the project's `faults` or
///     with the worst dead device.
/// A request, and requests that take turns, have one finding, which names the late variables, the worst one
/// first. With `prove` everything late without failures is an error. At most ten errors and three warnings of
/// each kind per line; the last one reports how many more there are.
///
/// Codes: guarantee.late, .unbounded (variable, device, response, deadline, over), .overload (line,
/// utilization), .late_with_fault, .late_with_dead (variable, device, response, deadline),
/// .response_unknown, .response_learning (line, devices, utilization), .unlimited, .more (line, count),
/// .rough (line).
/// @param guarantees  of that plan
[[nodiscard]] std::vector<model::Finding> guarantee_findings(const model::Project& project, const Plan& plan,
                                                             std::span<const LineGuarantee> guarantees,
                                                             bool prove = false);

/// The names of the devices whose turnaround is not known: the proof takes their time-outs, so its load is no
/// estimate. Of more than three the first three and their number; empty: each one is known.
[[nodiscard]] std::string unknown_turnarounds(const model::Line& line);

/// All codes of guarantee_findings(). Each has a message and, with ".advice", an advice in module `text`.
[[nodiscard]] std::span<const std::string_view> guarantee_finding_codes();

/// The names of these variables. Of more than four: the first three, the last and their number.
[[nodiscard]] std::string names_text(const model::Device& device, std::span<const std::size_t> variables);

/// A time as in findings: "117.721 ms".
[[nodiscard]] std::string time_text(Duration time);

}  // namespace takt::plan
