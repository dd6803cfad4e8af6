// The samples of one output, from the events of a host into its queue.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "takt/host/configuration.hpp"
#include "takt/publish/sample_codec.hpp"
#include "takt/publish/sample_queue.hpp"
#include "takt/publish/sample_selector.hpp"

namespace takt::publish {

/// The series of a configuration, by slot.
using SeriesTable = std::vector<Series>;
[[nodiscard]] std::shared_ptr<const SeriesTable> series_of(const host::Configuration& configuration);

/// Selects the samples of an output and collects them into payloads. One for each output and configuration.
/// The sampling thread only.
class SampleFeed {
public:
    /// @param queue  outlives it
    SampleFeed(std::shared_ptr<const SeriesTable> series, const std::vector<SelectedSlot>& selected,
               SampleQueue& queue, Instant start);

    /// Wall time minus the time of the host, for the samples that follow.
    void set_clock(std::int64_t wall_minus_host_ns) { offset_ns_ = wall_minus_host_ns; }

    /// @param event  whose body is `changed`
    void on_change(const host::Event& event, const host::ValueChanged& changed) {
        selector_.on_change(event, changed, sink_);
    }
    [[nodiscard]] Instant next_due() const { return selector_.next_due(); }
    void on_snapshot(const host::Snapshot& snapshot) { selector_.on_snapshot(snapshot, sink_); }
    void deliver_current(const host::Snapshot& snapshot) { selector_.deliver_current(snapshot, sink_); }
    /// The destination has lost the values that it kept.
    [[nodiscard]] bool retained_requested() const { return queue_.retained_requested(); }
    /// Delivers them again, if it has.
    void deliver_retained(const host::Snapshot& snapshot) {
        if (queue_.take_retained_request()) selector_.deliver_current(snapshot, sink_, true);
    }

    /// Events that were lost before they could be read. Each may have been a sample.
    void lose(std::uint64_t events, Instant first, Instant last);

    [[nodiscard]] bool collected() const { return !payload_.empty(); }
    /// Enqueues what was collected. @returns whether the thread of the output must be woken, also for a
    /// payload that was enqueued before because it was full
    [[nodiscard]] bool flush();

private:
    void add(const SelectedSample& sample);
    void enqueue();
    [[nodiscard]] std::int64_t wall_ns(Instant t) const { return t.time_since_epoch().count() + offset_ns_; }

    std::shared_ptr<const SeriesTable> series_;
    SampleSelector selector_;
    SampleQueue& queue_;
    SamplePayload payload_;
    SampleSelector::Sink sink_;
    std::int64_t offset_ns_ = 0;
    std::int64_t first_wall_ns_ = 0;  // of the samples in payload_
    Instant newest_;
    bool wake_ = false;
};

}  // namespace takt::publish
