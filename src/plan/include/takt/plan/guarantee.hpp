// What is proved about a plan: the longest response of each request and the greatest age of each value
// (docs/guarantees.md; specification, section 10).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Of one request, each rounded up to whole microseconds. Nothing: there is no bound.
struct Bound {
    Duration transaction{};                       ///< C, with the proved turnaround; of all its transactions
    Duration failure{};                           ///< F
    std::optional<Duration> response;             ///< R
    std::optional<Duration> response_with_fault;  ///< R under the project's faults
    std::optional<Duration> response_with_dead;   ///< R with the worst single dead device
    std::optional<Duration> deadline;             ///< D
    std::optional<Duration> age;                  ///< T + R, the greatest among its values
};

/// What makes a request due.
enum class Cause : std::uint8_t { period, read_trigger, write };

/// One cause of one request; requests of one stream are due together and have the same bounds.
struct JobBound {
    std::size_t request = 0;  ///< of the plan's
    Cause cause = Cause::period;
    /// Behind no admission, or polled as fast as the line allows: it has no bound. The former is left out of
    /// the bounds of others.
    bool limited = true;
    Bound bound;

    /// It has a deadline and misses it, or nothing proves that it does not.
    [[nodiscard]] bool late() const { return misses(bound.response); }
    [[nodiscard]] bool late_with_fault() const { return misses(bound.response_with_fault); }
    [[nodiscard]] bool late_with_dead() const { return misses(bound.response_with_dead); }

private:
    [[nodiscard]] bool misses(const std::optional<Duration>& response) const {
        return limited && bound.deadline && (!response || *response > *bound.deadline);
    }
};

struct LineGuarantee {
    std::size_t line = 0;
    /// In the order of the plan's requests: of the period where it is polled with one, else of the cause with
    /// the longest response.
    std::vector<Bound> requests;
    std::vector<JobBound> jobs;  ///< in the order of the requests
    /// The greatest age of each variable of each device; nothing: not polled with a period, or unbounded.
    std::vector<std::vector<std::optional<Duration>>> ages;
    double utilization = 0;  ///< with C, of all that is limited
    /// All polled values, and all commands behind an admission, hold their deadlines without failures.
    bool feasible = true;
    bool feasible_edf = true;  ///< second opinion: earliest deadline first
    /// Requests that are due without limit: nothing is proved of what they do to others.
    std::size_t unlimited = 0;
};

/// How much is to be proved.
enum class Scope : std::uint8_t {
    everything,
    without_failures,  ///< no response with faults or a dead device, no second opinion: those stay empty
};

/// The guarantees of each line, in order. Where a device may have its holes tried (gaps: learn), each bound
/// is the larger of that of the plan and of the plan in which no hole is confirmed: of a request that of the
/// requests which read its values there.
/// @param plan     of that project, made with those options
[[nodiscard]] std::vector<LineGuarantee> guarantee(const model::Project& project, const Plan& plan,
                                                   const Options& options = {},
                                                   Scope scope = Scope::everything);

/// Of one line and exactly that plan.
[[nodiscard]] LineGuarantee guarantee_line(const model::Project& project, const LinePlan& plan,
                                           Scope scope = Scope::everything);

/// How long the engine waits for the first byte of an answer: the turnaround where it is known and
/// derive_timeouts is not off, else the response timeout, and so where several requests may be under way on
/// the line's connection; at least t3.5 on RTU lines. The time-out is this, the length of the answer, and the
/// margin (docs/planning.md, bus time).
[[nodiscard]] Duration answer_wait(const model::Project& project, const model::Line& line,
                                   const model::Device& device);

/// The deadline of a request that is polled: the least explicit one of its variables, else its period.
[[nodiscard]] Duration polling_deadline(const model::Device& device, const Request& request);

}  // namespace takt::plan
