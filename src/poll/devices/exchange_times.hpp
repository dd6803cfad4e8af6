// Where the time of a line goes.
#pragma once

#include "devices/compact_times.hpp"
#include "line/heap_optional.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/poll/statistics.hpp"

namespace takt::poll {

/// Histograms of the parts of a line's time, each made with its first sample. Allocates when a sample is
/// shorter or longer than all before it (CountRange). One owner, one thread.
class ExchangeTimes {
public:
    /// A transaction was answered.
    /// @param delay  bus::response_delay(); negative ones of a port without a bit rate count as 0
    void on_response(const bus::LineConfig& config, const bus::Outcome& outcome, Duration delay);
    /// The line was woken that long after the instant for which it had asked.
    void on_wakeup(Duration late) { record(host_, late); }

    [[nodiscard]] LineTimes times() const;

private:
    using Times = HeapOptional<CompactLatencyStatistics>;
    static void record(Times& times, Duration sample);

    Times wire_;
    Times turnaround_;
    Times host_;
};

}  // namespace takt::poll
