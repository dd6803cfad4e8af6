// Which states of the selected values an output delivers: changes, periods and heartbeats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/host/event.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/publish/sample.hpp"
#include "takt/value/store.hpp"

namespace takt::publish {

struct SamplePolicy {
    bool on_change = true;
    Duration period{};      ///< zero: none
    Duration heartbeat{};   ///< a sample when the last one is that old; zero: none
    double dead_band = 0;   ///< a number that differs by at most this from the last sample is no change
    bool skip_bad = false;  ///< only values of good quality are delivered
    bool retained = false;  ///< the destination keeps the last value, and may lose it
};

struct SelectedSlot {
    value::SlotId slot;  ///< each at most once
    SamplePolicy policy;
};

/// A sample in the time of the host.
struct SelectedSample {
    value::SlotId slot;
    value::Value value;
    value::Quality quality = value::Quality::good;
    value::Reason reason = value::Reason::ok;
    SampleCause cause = SampleCause::change;
    Instant at;  ///< a good value: when it was read; else when the quality changed
    /// Of a change to a good value: the read before. Of a value that is not good: the last good read.
    std::optional<Instant> previous;
};

/// Decides for one output. Pure: driven by the events and snapshots of one configuration, in their order.
///
/// A change of quality or reason is always a sample, unless bad values are skipped. Periods begin at the
/// start and do not drift; a period that was missed is not made up for.
class SampleSelector {
public:
    using Sink = std::function<void(const SelectedSample&)>;

    SampleSelector(const std::vector<SelectedSlot>& selected, Instant start);

    /// @param event  whose body is `changed`
    void on_change(const host::Event& event, const host::ValueChanged& changed, const Sink& sink);

    /// When a snapshot is needed; kNever: no period or heartbeat is selected.
    [[nodiscard]] Instant next_due() const;
    /// @param snapshot  with all values. All events up to the end of the copy, and perhaps newer ones, were
    ///                  passed to on_change()
    void on_snapshot(const host::Snapshot& snapshot, const Sink& sink);
    /// Delivers the current state of all selected slots that were ever read: at the start, and after lost
    /// events.
    /// @param retained_only  of those with SamplePolicy::retained, because the destination has lost them
    void deliver_current(const host::Snapshot& snapshot, const Sink& sink, bool retained_only = false);

    [[nodiscard]] std::size_t size() const { return entries_.size(); }

private:
    struct State {
        value::Value value;
        value::Quality quality = value::Quality::never_read;
        value::Reason reason = value::Reason::ok;
        std::optional<Instant> good_at;
        Instant t;                 // of the event or snapshot
        std::uint64_t events = 0;  // it has the changes of all events before this number
    };
    struct Entry {
        value::SlotId slot;
        SamplePolicy policy;
        State seen;                      // the newest
        std::optional<State> delivered;  // the last sample
        Instant delivered_at;
        Instant next_period = kNever;
    };
    struct Due {
        Instant at;
        std::size_t entry = 0;
    };

    void deliver(Entry& entry, Instant t, SampleCause cause, std::optional<Instant> previous,
                 const Sink& sink);
    static void see(Entry& entry, const host::Snapshot& snapshot);
    void on_due(const host::Snapshot& snapshot, std::size_t index, const Sink& sink);
    [[nodiscard]] Instant due_of(const Entry& entry) const;
    void schedule(std::size_t index);

    std::vector<Entry> entries_;
    std::vector<std::uint32_t> entry_of_;  // by slot: index into entries_ plus 1; 0: not selected
    std::vector<Due> dues_;  // a heap, the earliest first; one for each entry that has a due time
};

}  // namespace takt::publish
