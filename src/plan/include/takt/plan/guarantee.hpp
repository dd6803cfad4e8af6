// The guarantees of a plan: the longest response of each request and the greatest age of each value
// (docs/guarantees.md; docs/specification.md, section 10).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "takt/plan/plan.hpp"
#include "takt/plan/request_job.hpp"
#include "takt/plan/response.hpp"

namespace takt::plan {

/// Bounds of one request, rounded up to microseconds. Nothing: unbounded.
struct Bound {
    Duration transaction{};                       ///< C, with the proved turnaround; of all its transactions
    Duration failure{};                           ///< F
    std::optional<Duration> response;             ///< R
    std::optional<Duration> response_with_fault;  ///< R under the project's faults
    std::optional<Duration> response_with_dead;   ///< R with the worst single dead device
    std::optional<Duration> deadline;             ///< D
    std::optional<Duration> age;                  ///< T + R, the greatest among its values
};

/// One cause of one request; requests of one stream are due together and have the same bounds.
struct JobBound {
    std::size_t request = 0;  ///< of the plan's
    Cause cause = Cause::period;
    /// Unbounded: without a rate limit, or polled as fast as the line allows. Requests without a rate limit
    /// are not counted in the bounds of others.
    bool limited = true;
    Bound bound;

    /// The deadline is missed, or not proved.
    [[nodiscard]] bool late() const { return misses(bound.response); }
    [[nodiscard]] bool late_with_fault() const { return misses(bound.response_with_fault); }
    [[nodiscard]] bool late_with_dead() const { return misses(bound.response_with_dead); }

private:
    [[nodiscard]] bool misses(const std::optional<Duration>& response) const {
        return limited && bound.deadline && (!response || *response > *bound.deadline);
    }
};

/// What the response times of a proof are, from the best to the worst.
enum class ResponseSource : std::uint8_t {
    written,   ///< `turnaround` of each device: as good as who wrote it
    measured,  ///< of some devices; the confidence follows from the number of exchanges
    time_out,  ///< of some devices nothing is known but their time-out
};
[[nodiscard]] std::string_view name(ResponseSource source);
/// The worst one of the devices of a line.
[[nodiscard]] ResponseSource response_source(const model::Line& line);

struct LineGuarantee {
    std::size_t line = 0;
    /// In the order of the plan's requests. Bounds of the period if the request has one, else of the cause
    /// with the longest response.
    std::vector<Bound> requests;
    std::vector<JobBound> jobs;  ///< in the order of the requests
    /// The greatest age of each variable of each device; nothing: not polled with a period, or unbounded.
    std::vector<std::vector<std::optional<Duration>>> ages;
    /// The same with failures: under the project's faults, and with the worst single dead device where that
    /// has a bound. Only with Scope::everything.
    std::vector<std::vector<std::optional<Duration>>> ages_with_failures;
    /// With C, of all requests with a period or a rate limit; at least 1 with a request of period 0.
    double utilization = 0;
    double relayed_share = 0;  ///< of the utilization: relayed requests, at most
    double client_share = 0;   ///< of the utilization: commands of clients, at most
    /// Without failures all polled values, and all commands with a rate limit, meet their deadlines.
    bool feasible = true;
    bool feasible_edf = true;  ///< second opinion: earliest deadline first; several in flight: as `feasible`
    std::uint32_t in_flight = 1;  ///< requests at a time
    /// The analysis ended before its limit (Effort). With one request in flight each bound is then exact for
    /// the tasks of the line. False: some bounds are larger, or missing.
    bool exact = true;
    /// There are requests without a rate limit. Their effect on others is not proved.
    std::size_t unlimited = 0;
};

/// The extent of the proof.
enum class Scope : std::uint8_t {
    everything,
    /// No response with faults or a dead device, no age, no second opinion: those stay empty.
    without_failures,
};

/// The guarantees of each line, in order. If a device tries gaps (gaps: learn), each bound is the larger one
/// of this plan and of the plan without confirmed gaps, whose requests are matched by the values that they
/// read. When the analyses of many lines near full load have taken a second or so, the bounds of further
/// lines may be the larger ones of Effort::most (LineGuarantee::exact).
/// @param plan  of that project, made with those options
[[nodiscard]] std::vector<LineGuarantee> guarantee(const model::Project& project, const Plan& plan,
                                                   const Options& options = {},
                                                   Scope scope = Scope::everything);

/// The guarantees of one line, as guarantee() gives them. They do not depend on the other lines.
/// @param confirmed  confirmed_only(project); read only if the line learns
/// @param effort     of its analyses; nullptr: Effort()
[[nodiscard]] LineGuarantee guarantee_line(const model::Project& project, const model::Project& confirmed,
                                           const LinePlan& plan, const Options& options = {},
                                           Scope scope = Scope::everything, Effort* effort = nullptr);

/// The guarantees of one line and exactly that plan.
[[nodiscard]] LineGuarantee guarantee_line(const model::Project& project, const LinePlan& plan,
                                           Scope scope = Scope::everything, Effort* effort = nullptr);

/// The time that the engine waits for the first byte of an answer: Device::wait(), which is not derived with
/// several requests in flight on the connection. At least t3.5 on RTU lines. The time-out is this time + the
/// length of the answer + the margin (docs/planning.md, "Bus time").
[[nodiscard]] Duration answer_wait(const model::Project& project, const model::Line& line,
                                   const model::Device& device);

}  // namespace takt::plan
