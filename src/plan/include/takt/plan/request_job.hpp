// The scheduling facts of requests. The proof, the poller and the builder of request tables take them from
// here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/base/inplace_vector.hpp"
#include "takt/plan/plan.hpp"
#include "takt/plan/response.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::plan {

/// The cause of a request.
enum class Cause : std::uint8_t { period, read_trigger, write };

/// The treatment of a cause (docs/guarantees.md, "Model"; bus::Arbiter has the order of transactions).
enum class JobClass : std::uint8_t {
    polled,       ///< with a period: by its deadline
    triggered,    ///< a read for a trigger with a rate limit: ahead of polling
    command,      ///< a write with a rate limit: ahead of polling
    best_effort,  ///< period 0, and events without a rate limit of their own: no bound
};

struct TransactionCost {
    Microseconds transaction = 0;  ///< C
    Microseconds failure = 0;      ///< F
};

/// The transactions of one request, in order.
using RequestCosts = InplaceVector<TransactionCost, 2>;

/// One cause of one request.
struct RequestJob {
    Cause cause = Cause::period;
    JobClass job_class = JobClass::polled;
    /// The distance of its releases; of an event the least mean distance that its rate limit allows. Zero:
    /// as fast as the line allows, or without a rate limit.
    Duration period{};
    Duration phase{};  ///< of its releases
    /// From the release, or the arrival of the event. Nothing: an event without a rate limit.
    std::optional<Duration> deadline;
    std::optional<model::RateLimit> admission;  ///< of an event
    std::vector<std::size_t> members;  ///< the variables that it reads or writes, of Request::variables
    /// The read of a read-modify-write. It is the first transaction.
    std::optional<wire::ReadRequest> read_before;
    std::optional<wire::ReadRequest> read_back;  ///< verifies what was written
    /// Of the normal response to the first transaction. A 0x17 that only reads is sent as 0x03.
    wire::Function function = wire::Function::read_holding_registers;
    std::uint16_t response_length = 0;  ///< PDU bytes
    RequestCosts costs;                 ///< with the proved turnaround; see TransactionCosts
};

/// @returns nothing if the request does not have that cause
[[nodiscard]] std::optional<RequestJob> job_of(const model::Project& project, const model::Line& line,
                                               const Request& request, Cause cause);

/// Whether a request writes the variable, which is one of its own: all of them; with 0x17 those of its write
/// trigger in the range that it writes.
[[nodiscard]] bool is_written(const Request& request, const model::Variable& variable);

/// The deadline by which the polled requests of a plan are ordered; zero: as fast as the line allows.
[[nodiscard]] Duration polling_deadline(const Request& request);

/// The back-off of a device: its own, else that of the project.
[[nodiscard]] const model::Backoff& backoff_of(const model::Project& project, const model::Device& device);

/// The most requests in flight on the connection of a line: 1, more only with Framing::tcp. With several, a
/// response waits for those to the requests before it: time-outs are then not derived from turnarounds.
[[nodiscard]] std::size_t requests_in_flight(const model::Line& line);

/// The read that a request sends for its period or its trigger. It has a read.
[[nodiscard]] wire::ReadRequest planned_read(const Request& request);

/// The read that verifies what the request has written. It has a write.
[[nodiscard]] wire::ReadRequest read_back_of(const Request& request);
/// The same for a variable that is written alone.
[[nodiscard]] wire::ReadRequest read_back_of(const model::Variable& variable);
/// The read of a read-modify-write of bits of that register.
[[nodiscard]] wire::ReadRequest read_before_write(std::uint16_t start, std::uint16_t quantity);

}  // namespace takt::plan
