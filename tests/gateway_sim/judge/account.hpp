// What the gateway sampled, run by run, in the order in which it entered the output.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/publish/sample.hpp"
#include "takt/publish/sample_queue.hpp"

namespace takt::gatewaysim {

/// Samples that entered the output together, or a number of lost ones.
struct Unit {
    publish::QueuedSamples queued;
    publish::SampleBatch batch;  ///< of the payload; empty: they are lost
    Instant pushed;
    bool did_not_fit = false;       ///< the queue in front of the journal was full
    std::uint64_t offset = 0;       ///< samples of the run before it
    std::uint64_t not_durable = 0;  ///< bytes of the run that were not on the disk, this unit included

    [[nodiscard]] bool lost() const { return queued.payload.empty(); }
    [[nodiscard]] std::uint64_t count() const { return queued.samples; }
};

/// A start of the program up to its end. The samples of a run have the numbers base + 1, base + 2, … in the
/// stream.
struct Run {
    std::uint32_t number = 0;
    Instant begin;
    std::int64_t opened_wall_ns = 0;   ///< wall time when the journal was opened last
    std::uint64_t epoch = 0;           ///< 0: nothing was written yet
    std::uint64_t base = 0;            ///< samples of the stream before the run
    std::uint64_t first_sequence = 0;  ///< of its first record
    std::uint64_t total = 0;           ///< samples that entered the output
    std::optional<std::uint64_t> end;  ///< samples of the stream up to its last record that survived
    std::deque<Unit> units;
    bool cursor_failed = false;  ///< a cursor could not be written or was not synchronised
    bool restart_sent = false;
    bool restart_received = false;
    bool restart_finished = false;

    [[nodiscard]] const Unit* unit_of(std::uint64_t number_in_stream) const;
};

class Account {
public:
    Run& begin_run(Instant t);
    [[nodiscard]] bool empty() const { return runs_.empty(); }
    [[nodiscard]] Run& current() { return runs_.back(); }
    [[nodiscard]] const Run& current() const { return runs_.back(); }
    [[nodiscard]] std::deque<Run>& runs() { return runs_; }
    /// The last run with this epoch; nullptr: there is none.
    [[nodiscard]] Run* run_of(std::uint64_t epoch);
    /// Adds a unit to the current run.
    Unit& add(Unit unit);

private:
    std::deque<Run> runs_;
};

}  // namespace takt::gatewaysim
