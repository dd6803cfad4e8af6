// Worst-case response times of a connection with several requests in flight (docs/guarantees.md, "Several
// requests in flight"; docs/decisions/0047-requests-in-flight.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "takt/plan/response.hpp"

namespace takt::plan {

/// Tasks of which less is in flight at a time than the connection allows: those of a device, or its writes.
struct Lane {
    std::vector<std::size_t> tasks;
    std::uint32_t in_flight = 1;
};

/// A connection that carries up to `in_flight` transactions at a time. The master starts the most urgent
/// request as soon as fewer are in flight, and its lanes have room. Each transaction ends within the C of its
/// task. Others in flight do not change this. A request is not sent again before its last transaction has
/// ended.
struct Connection {
    std::uint32_t in_flight = 2;
    /// For so long a start may be delayed by the start or the end of another transaction.
    Microseconds pause = 0;
    std::vector<Lane> lanes;
    std::vector<bool>
        alone;  ///< by task: while one of its jobs waits and runs, nothing else starts. May be empty
};

/// Fixed priority, without failures. An upper bound: the exact worst case of several servers is not known.
/// @param tasks   as of response_times(); Task::late is not regarded, because Framing::tcp has no such waits
/// @param effort  nullptr: Effort(). Beyond its limit the remaining tasks have no bound
[[nodiscard]] Responses parallel_response_times(std::span<const Task> tasks, const Connection& connection,
                                                Effort* effort = nullptr);

/// With failed attempts, as response_times_with_faults().
[[nodiscard]] Responses parallel_response_times_with_faults(std::span<const Task> tasks,
                                                            const Connection& connection,
                                                            const FaultRate& faults,
                                                            Effort* effort = nullptr);

/// With the worst single dead device, as response_times_with_dead_device().
[[nodiscard]] Responses parallel_response_times_with_dead_device(std::span<const Task> tasks,
                                                                 const Connection& connection,
                                                                 Effort* effort = nullptr);

}  // namespace takt::plan
