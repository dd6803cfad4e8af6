#include "takt/plan/request_job.hpp"

#include <algorithm>

#include "cost/transaction_cost.hpp"
#include "takt/base/assert.hpp"
#include "timing/admission.hpp"

namespace takt::plan {
namespace {

using wire::Function;

bool is_exchange(const Request& request) {
    return request.write == Function::read_write_multiple_registers;
}

bool has_cause(const Request& request, Cause cause) {
    switch (cause) {
        case Cause::period: return request.read && request.period;
        case Cause::read_trigger: return request.read && request.read_trigger;
        case Cause::write: break;
    }
    return request.write && (request.write_on_change || request.write_trigger);
}

std::optional<model::RateLimit> admission(const model::Project& project, const Request& request,
                                          Cause cause) {
    if (cause == Cause::read_trigger) return trigger_admission(project, request.read_trigger);
    if (request.admission || request.write_on_change) return request.admission;
    return trigger_admission(project, request.write_trigger);
}

// A request that is also polled has the deadline of its polling.
std::optional<Duration> event_deadline(const model::Device& device, const Request& request,
                                       const std::optional<model::RateLimit>& admission) {
    if (!admission) return std::nullopt;
    if (!request.period && request.deadline) return request.deadline;
    return least_deadline(device, request).value_or(admission->min_interval);
}

void set_event(const model::Project& project, const model::Device& device, const Request& request,
               RequestJob& job) {
    job.admission = admission(project, request, job.cause);
    job.deadline = event_deadline(device, request, job.admission);
    const bool limited = job.admission && job.admission->min_interval > Duration::zero();
    job.job_class = !limited                           ? JobClass::best_effort
                    : job.cause == Cause::read_trigger ? JobClass::triggered
                                                       : JobClass::command;
    if (limited) job.period = job.admission->min_interval;
}

void set_polled(const Request& request, RequestJob& job) {
    job.job_class = *request.period > Duration::zero() ? JobClass::polled : JobClass::best_effort;
    job.period = *request.period;
    job.phase = request.phase;
    job.deadline = polling_deadline(request);
}

void set_write(const model::Device& device, const Request& request, RequestJob& job) {
    for (const std::size_t v : request.variables)
        if (is_written(request, device.variables[v])) job.members.push_back(v);
    const bool verified = std::ranges::any_of(
        request.variables, [&](std::size_t v) { return is_verified(request, device.variables[v]); });
    if (verified) job.read_back = read_back_of(request);
    if (request.read_modify_write) job.read_before = read_before_write(request.start, request.quantity);
    job.function = job.read_before ? job.read_before->function : *request.write;
}

}  // namespace

std::optional<RequestJob> job_of(const model::Project& project, const model::Line& line,
                                 const Request& request, Cause cause) {
    if (!has_cause(request, cause)) return std::nullopt;
    const model::Device& device = line.devices[request.device];
    const TransactionCosts costs(project, line);
    RequestJob job{.cause = cause};
    if (cause == Cause::period)
        set_polled(request, job);
    else
        set_event(project, device, request, job);
    if (cause == Cause::write) {
        set_write(device, request, job);
        job.costs = costs.of_write(request);
    } else {
        job.members = request.variables;
        job.function = planned_read(request).function;
        job.costs = costs.of_read(request);
    }
    job.response_length =
        static_cast<std::uint16_t>(wire::response_pdu_length(job.function, request.quantity));
    return job;
}

bool is_written(const Request& request, const model::Variable& variable) {
    if (!is_exchange(request)) return true;
    const std::uint32_t start = variable.start();
    return variable.write && variable.write_trigger == request.write_trigger &&
           start >= request.write_start &&
           start + variable.items() <= std::uint32_t{request.write_start} + request.write_quantity;
}

bool is_verified(const Request& request, const model::Variable& variable) {
    return request.write && variable.write && variable.verify && is_written(request, variable);
}

// Only a period of 0 leaves a planned request without a deadline (deadline_of in admission.hpp).
Duration polling_deadline(const Request& request) {
    return request.deadline.value_or(Duration::zero());
}

const model::Backoff& backoff_of(const model::Project& project, const model::Device& device) {
    return device.backoff ? *device.backoff : project.backoff;
}

std::size_t requests_in_flight(const model::Line& line) {
    std::size_t most = 1;
    if (line.framing == wire::Framing::tcp && !line.length_tolerance)
        for (const auto& device : line.devices) most = std::max<std::size_t>(most, device.in_flight);
    return most;
}

// 0x17 reads holding registers; where nothing is written, 0x03 reads the same.
wire::ReadRequest planned_read(const Request& request) {
    TAKT_ASSERT(request.read);
    const bool exchange = *request.read == Function::read_write_multiple_registers;
    return {exchange ? Function::read_holding_registers : *request.read, DataAddress{request.start},
            request.quantity};
}

// A range that one request can write, one request can read.
wire::ReadRequest read_back_of(const Request& request) {
    TAKT_ASSERT(request.write);
    const bool exchange = is_exchange(request);
    return {wire::read_function(wire::area_of(*request.write)),
            DataAddress{exchange ? request.write_start : request.start},
            exchange ? request.write_quantity : request.quantity};
}

wire::ReadRequest read_back_of(const model::Variable& variable) {
    return {wire::is_bit_area(variable.area) ? Function::read_coils : Function::read_holding_registers,
            DataAddress{variable.start()}, variable.items()};
}

wire::ReadRequest read_before_write(std::uint16_t start, std::uint16_t quantity) {
    return {Function::read_holding_registers, DataAddress{start}, quantity};
}

}  // namespace takt::plan
