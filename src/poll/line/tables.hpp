// The tables of a line: requests, devices, variables. LinePoller::Run owns and changes them; parts read them
// (LineTables).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "devices/compact_times.hpp"
#include "devices/delay_learner.hpp"
#include "devices/device_health.hpp"
#include "devices/noise_meter.hpp"
#include "line/heap_optional.hpp"
#include "line/transfer.hpp"
#include "reads/held_reads.hpp"
#include "reads/read_job.hpp"
#include "takt/bus/unit_times.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/line_poller.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/command.hpp"
#include "takt/value/store.hpp"

namespace takt::poll {

/// What was counted and measured of the transactions of a request. Another plan with the same request
/// continues it.
struct RequestTraffic {
    bus::TransactionCounters counters;
    bus::TimeStatistics attempt_time;              // of its reads, answered or not
    HeapOptional<CompactLatencyStatistics> times;  // of its responses; made with the first one
    std::uint64_t over_cost = 0;                   // RequestStatistics
    std::uint64_t late_refreshes = 0;              // likewise

    /// A transaction of a read, a write or both; `sent` or not.
    /// @param silence  after the response; part of `cost`
    /// @param cost     C
    void count(const bus::Outcome& outcome, Duration silence, Duration cost);
};

/// One request of the plan that runs.
struct RequestRun {
    const plan::Request* plan = nullptr;
    std::size_t device = 0;
    std::vector<std::size_t> variables;  // indices into Run::variables_
    std::optional<ReadJob> read;
    RequestTraffic traffic;
    Duration read_cost = Duration::max();   // C of its read
    Duration write_cost = Duration::max();  // the longest C of its write and what belongs to it
};

/// One device of the line, for as long as the poller lives.
struct DeviceRun {
    const model::Device* model = nullptr;
    std::vector<std::size_t> requests;
    DeviceHealth health;
    DelayLearner delay_learner;
    NoiseMeter noise_meter;
    bus::UnitTimes times;         // in this run; its lateness also in earlier ones
    std::uint16_t in_flight = 0;  // transactions
    std::uint16_t most_in_flight = 1;
    bool writing = false;       // one of them writes; writes keep their order
    bool relayed_last = false;  // a relayed request was sent to it after the last polled one
    HeldReads held;             // whose values are not published yet
    DeviceTraffic statistics;
};

/// Whether requests other than probes may be sent to it.
inline bool reachable(const DeviceRun& device) {
    return device.health.reachable();
}

/// It accepts no further transaction.
inline bool full(const DeviceRun& device) {
    return device.in_flight >= device.most_in_flight;
}

/// One variable of the line.
struct VariableRun {
    const model::Variable* model = nullptr;
    value::SlotId slot;
    std::uint32_t device = 0;
};

/// The tables of a line, for parts that only read them.
struct LineTables {
    const std::vector<VariableRun>& variables;
    const std::vector<DeviceRun>& devices;
    const std::vector<RequestRun>& requests;
};

}  // namespace takt::poll
