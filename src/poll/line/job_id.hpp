// The jobs of a line, as the arbiter and the engine name them.
#pragma once

#include <cstdint>

#include "takt/bus/arbiter.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::poll {

using bus::Candidate;
using bus::Urgency;

enum class JobKind : std::uint8_t { read, group_write, command, trial, relayed };

constexpr bool writes(JobKind kind) {
    return kind == JobKind::group_write || kind == JobKind::command;
}

/// The id of a transaction names the job that it belongs to; its outcome is dispatched by it. So does
/// Candidate::job.
/// @param index  of the request, or for a command its order
constexpr bus::TransactionId transaction_id(JobKind kind, std::uint64_t index) {
    return index << 3 | static_cast<std::uint64_t>(kind);
}

constexpr JobKind kind_of(bus::TransactionId id) {
    return static_cast<JobKind>(id & 7);
}

constexpr std::uint64_t index_of(bus::TransactionId id) {
    return id >> 3;
}

}  // namespace takt::poll
