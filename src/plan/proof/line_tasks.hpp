// A plan as tasks of the response-time analysis (docs/guarantees.md, "Model").
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "takt/plan/guarantee.hpp"
#include "takt/plan/response.hpp"
#include "timing/parallel_response.hpp"

namespace takt::plan {

/// One cause of one request, with its task.
struct LineJob {
    std::size_t request = 0;
    Cause cause = Cause::period;
    std::optional<std::size_t> task;  ///< nothing: without a rate limit
    Microseconds transaction = 0;     ///< C
    Microseconds failure = 0;         ///< F
    std::optional<Microseconds> deadline;
};

/// The reads of one unit, and the pause that shows that it is in step (step_check.hpp).
struct StepHold {
    std::vector<std::size_t> tasks;
    /// The tasks whose responses may have the same function and length. A task of several requests is in
    /// each of theirs.
    std::vector<std::vector<std::size_t>> by_shape;
    std::vector<std::size_t> periodic;  ///< tasks of one shape that are polled
    Microseconds pause = 0;             ///< shows that no further response comes
    Microseconds hold = 0;  ///< they wait so long, once each wire::kStepCheckInterval; others go meanwhile
};

struct LineTasks {
    std::vector<Task> tasks;
    std::vector<LineJob> jobs;             ///< in the order of the plan's requests
    std::vector<StepHold> holds;           ///< one for each unit that is read; on TCP none
    std::optional<std::size_t> relayed;    ///< the task of relayed requests
    std::optional<std::size_t> clients;    ///< the task of commands of clients
    std::optional<Connection> connection;  ///< several requests in flight

    /// Transactions at a time.
    [[nodiscard]] std::uint32_t in_flight() const { return connection ? connection->in_flight : 1; }
};

[[nodiscard]] LineTasks line_tasks(const model::Project& project, const LinePlan& plan);

/// The longest distance between two reads of each variable of each device; nothing: not polled with a period.
[[nodiscard]] std::vector<std::vector<std::optional<Duration>>> read_distances(const model::Line& line,
                                                                               const LinePlan& plan);

}  // namespace takt::plan
