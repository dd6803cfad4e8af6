// What an output does with its journal: the part that differs between kinds of outputs.
#pragma once

#include <span>

#include "takt/base/time.hpp"
#include "takt/publish/output_status.hpp"
#include "takt/store/journal.hpp"

namespace takt::publish {

/// Takes the records of a journal to a destination. All members are called by the thread of the output; none
/// may wait for the destination.
class OutputWork {
public:
    virtual ~OutputWork() = default;

    /// Called once, before all others.
    /// @param journal  open; outlives the work
    virtual void begin(Instant now, store::Journal& journal, store::DestinationId destination) = 0;

    /// Called when records became durable, when a descriptor is readable, and at next_wakeup(). May be called
    /// at other times too.
    virtual void work(Instant now) = 0;
    [[nodiscard]] virtual Instant next_wakeup() const = 0;
    /// Called after work(): whether the destination may have lost the values that it keeps. They are then
    /// sampled again.
    [[nodiscard]] virtual bool take_retained_request() { return false; }
    /// Descriptors to wait for. Valid until the next work().
    [[nodiscard]] virtual std::span<const int> descriptors() const = 0;

    /// The state of lines or devices changed.
    virtual void on_state_changed(Instant now) = 0;

    /// Whether work() takes records at this moment. The orderly end then waits until all are taken.
    [[nodiscard]] virtual bool takes_records() const = 0;
    /// Begins the orderly end; work() is called until stopped().
    virtual void stop(Instant now) = 0;
    [[nodiscard]] virtual bool stopped() const = 0;

    /// Adds state, destination, failure and the counts of this kind of output.
    virtual void report(Instant now, OutputStatus& status) const = 0;
};

}  // namespace takt::publish
