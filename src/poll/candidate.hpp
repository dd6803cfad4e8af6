// The candidates for the next request, and their order.
#pragma once

#include <cstdint>
#include <limits>

#include "takt/bus/transaction.hpp"

namespace takt::poll {

inline constexpr std::int64_t kNoDeadline = std::numeric_limits<std::int64_t>::max();
enum class Urgency : std::uint8_t { commanded, relayed, overdue, polled, background };
enum class JobKind : std::uint8_t { read, group_write, command, trial, relayed };

/// A request that may be sent next. Candidates compare by urgency, then by time, then by position in the
/// plan or order of arrival.
struct Candidate {
    Urgency urgency = Urgency::background;
    std::int64_t key = 0;
    std::uint64_t tie_break = 0;
    JobKind kind = JobKind::read;
    std::uint64_t index = 0;  // request, or for a command its order
    bool by_trigger = false;
    bool late = false;  // of polling: it has waited longer than its deadline

    [[nodiscard]] bool before(const Candidate& other) const {
        if (urgency != other.urgency) return urgency < other.urgency;
        return key != other.key ? key < other.key : tie_break < other.tie_break;
    }
};

constexpr bool writes(JobKind kind) {
    return kind == JobKind::group_write || kind == JobKind::command;
}

/// The id of a transaction names the job that it belongs to; its outcome is dispatched by it.
constexpr bus::TransactionId transaction_id(JobKind kind, std::uint64_t index) {
    return index << 3 | static_cast<std::uint64_t>(kind);
}

constexpr JobKind kind_of(bus::TransactionId id) {
    return static_cast<JobKind>(id & 7);
}

}  // namespace takt::poll
