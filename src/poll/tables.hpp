// The tables of a line: requests, devices, variables, gap learning, relayed transactions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "delay_learner.hpp"
#include "jobs.hpp"
#include "learning.hpp"
#include "takt/bus/transaction_gate.hpp"
#include "takt/plan/learning.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/line_poller.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/command.hpp"
#include "takt/value/store.hpp"
#include "transfer.hpp"

namespace takt::poll {

struct RequestRun {
    const plan::Request* plan = nullptr;
    std::size_t device = 0;
    std::vector<std::size_t> variables;       // indices into Run::variables_
    std::vector<model::LocalIndex> statuses;  // the different ones of its variables
    std::optional<ReadJob> read;
    value::Reason last_reason = value::Reason::ok;
    bus::TransactionCounters counters;
    std::uint64_t skipped = 0;         // releases
    bus::TimeStatistics attempt_time;  // of its reads, answered or not
};

struct DeviceRun {
    const model::Device* model = nullptr;
    std::vector<std::size_t> requests;
    Duration wait{};  // delay_learner.wait()
    Health health{1};
    Instant failing_since;  // start of the first of the failed attempts in a row
    DelayLearner delay_learner;
    bool enabled = true;
    std::uint16_t in_flight = 0;  // transactions
    std::uint16_t most_in_flight = 1;
    bool writing = false;  // one of them writes; writes keep their order
    bool has_reads = false;
    bool relayed_last = false;  // a relayed request was sent to it after the last polled one
    DeviceStatistics statistics;
};

/// Whether requests other than probes may be sent to it: it is switched on and answers. A device without
/// reads is not probed; its writes serve as probes.
inline bool reachable(const DeviceRun& device) {
    return device.enabled && (device.health.answering() || !device.has_reads);
}

/// It accepts no further transaction.
inline bool full(const DeviceRun& device) {
    return device.in_flight >= device.most_in_flight;
}

struct VariableRun {
    const model::Variable* model = nullptr;
    value::SlotId slot;
    std::uint32_t device = 0;
    std::optional<std::uint32_t> split;  // index into Run::splits_
    PeriodMeter meter{Duration::zero()};
    std::uint32_t age_group = UINT32_MAX;           // of AgeLimits; else none
    Duration age_when_published{};                  // of a value that not the read of its request has read
    value::Reason last_result = value::Reason::ok;  // of its last read or write
    bool away = false;                              // its status is that of its device, not last_result
};

/// The state of a line that learns (trials.cpp, replan.cpp).
struct GapLearner {
    Learning learning;
    PlanMaker* plan_maker = nullptr;
    plan::LinePlan plan;                             // the running plan
    std::optional<std::vector<plan::Trial>> trials;  // of the first plan
    bool plan_wanted = false;                        // requested from the PlanMaker
    std::optional<plan::LearningPlan> next_plan;     // runs as soon as no transaction is in flight
    std::optional<Learning::TrialRead> trial_read;   // waits or is in flight
    std::optional<Instant> waiting_since;            // for a moment without due requests
    Instant last_start = Instant::min();
};

/// Transactions of clients that share the line.
struct RelayRun {
    bus::TransactionGate gate;                    // of those that go before polling
    std::optional<bus::Transaction> transaction;  // waits or is in flight
    std::optional<std::size_t> device;            // its device, if the project has it
    bool only_reads = false;
    bool in_flight = false;
    Instant last_start = Instant::min();
    std::optional<bus::Outcome> outcome;  // not taken yet
    wire::Pdu response;                   // the bytes of its response, which outlive the engine's buffer
};

}  // namespace takt::poll
