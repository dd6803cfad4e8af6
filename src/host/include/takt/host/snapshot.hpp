// A copy of what a host knows at one moment.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/endpoint/statistics.hpp"
#include "takt/host/configuration.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/store.hpp"

namespace takt::host {

/// Which parts a snapshot has.
struct SnapshotParts {
    bool values = true;
    bool statistics = false;  ///< of lines, devices, requests and variables
    bool times = false;       ///< histograms of requests and lines, with statistics
    bool plan = false;        ///< the plans that run
    bool learnt = false;      ///< of devices with `gaps: learn`
    bool endpoints = false;   ///< statistics of the project's servers
};

/// Vectors of parts that were not asked for are empty.
struct Snapshot {
    struct Line {
        bool up = false;
        bool was_up = false;       ///< at some time
        std::optional<Error> why;  ///< of a link that is down
        poll::LineStatistics statistics;
        std::vector<poll::DeviceStatistics> devices;         ///< by index in the line
        std::vector<model::MeasuredTimes> times;             ///< likewise
        std::vector<poll::RequestStatistics> requests;       ///< by index in `plan`, which then is there too
        std::vector<poll::HistogramSnapshot> request_times;  ///< likewise
        std::vector<poll::VariableStatistics> variables;     ///< of all devices, in the order of the project
        std::shared_ptr<const plan::LinePlan> plan;          ///< that runs
        std::vector<model::Learnt> learnt;                   ///< by index of the device
    };

    ConfigurationPtr configuration;
    Instant started;  ///< when the host began
    Instant t;        ///< when the copy was complete; values may have changed since they were copied
    /// Event::number: each value has the changes of all events before this one, and of no event that comes
    /// after the copy. Events between may be newer or older than the value.
    std::uint64_t first_newer_event = 0;
    /// By SlotId. The members of one request are of one moment: the host copies a device between two
    /// transactions.
    std::vector<value::Slot> values;
    std::vector<Line> lines;
    std::vector<poll::LineTimes> line_times;  ///< by line
    endpoint::Statistics endpoints;
};

}  // namespace takt::host
