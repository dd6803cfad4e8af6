// Every entry with a period or a heartbeat is in the heap once. A heartbeat moves with each sample, and its
// entry in the heap does not: when that is reached too early, it is put back with the time that counts now.
#include "takt/publish/sample_selector.hpp"

#include <algorithm>
#include <cmath>

#include "takt/base/assert.hpp"

namespace takt::publish {
namespace {

std::optional<double> finite_number(const value::Value& value) {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*u);
    if (const auto* d = std::get_if<double>(&value); d && std::isfinite(*d)) return *d;
    return std::nullopt;
}

bool moved(const value::Value& from, const value::Value& to, double dead_band) {
    if (value::same(from, to)) return false;
    const auto a = finite_number(from);
    const auto b = finite_number(to);
    return !a || !b || !(std::abs(*b - *a) <= dead_band);
}

bool later(const auto& a, const auto& b) {
    return a.at > b.at;
}

}  // namespace

SampleSelector::SampleSelector(const std::vector<SelectedSlot>& selected, Instant start) {
    for (const auto& [slot, policy] : selected) {
        TAKT_ASSERT(policy.period >= Duration{} && policy.heartbeat >= Duration{});
        if (slot.value >= entry_of_.size()) entry_of_.resize(slot.value + 1);
        TAKT_ASSERT(entry_of_[slot.value] == 0);
        Entry entry{.slot = slot, .policy = policy, .seen = {}, .delivered = {}, .delivered_at = start};
        if (policy.period > Duration{}) entry.next_period = start + policy.period;
        entries_.push_back(std::move(entry));
        entry_of_[slot.value] = static_cast<std::uint32_t>(entries_.size());
        schedule(entries_.size() - 1);
    }
}

Instant SampleSelector::due_of(const Entry& entry) const {
    const auto heartbeat = entry.policy.heartbeat;
    const auto beat = heartbeat > Duration{} ? entry.delivered_at + heartbeat : kNever;
    return std::min(entry.next_period, beat);
}

void SampleSelector::schedule(std::size_t index) {
    const auto at = due_of(entries_[index]);
    if (at == kNever) return;
    dues_.push_back({at, index});
    std::ranges::push_heap(dues_, later<Due, Due>);
}

Instant SampleSelector::next_due() const {
    return dues_.empty() ? kNever : dues_.front().at;
}

void SampleSelector::deliver(Entry& entry, Instant t, SampleCause cause, std::optional<Instant> previous,
                             const Sink& sink) {
    const auto& seen = entry.seen;
    const bool good = seen.quality == value::Quality::good;
    if (entry.policy.skip_bad && !good) return;
    entry.delivered = seen;
    entry.delivered_at = t;
    sink({.slot = entry.slot,
          .value = seen.value,
          .quality = seen.quality,
          .reason = seen.reason,
          .cause = cause,
          .at = good && seen.good_at ? *seen.good_at : (cause == SampleCause::change ? seen.t : t),
          .previous = good ? previous : seen.good_at});
}

void SampleSelector::on_change(const host::Event& event, const host::ValueChanged& changed,
                               const Sink& sink) {
    if (changed.slot.value >= entry_of_.size() || entry_of_[changed.slot.value] == 0) return;
    auto& entry = entries_[entry_of_[changed.slot.value] - 1];
    entry.seen = {changed.value, changed.quality, changed.reason, changed.good_at, event.t, event.number + 1};
    if (!entry.policy.on_change) return;
    const auto& last = entry.delivered;
    const bool graded = !last || last->quality != changed.quality || last->reason != changed.reason;
    if (graded || moved(last->value, changed.value, entry.policy.dead_band))
        deliver(entry, event.t, SampleCause::change, changed.good_before, sink);
}

void SampleSelector::on_snapshot(const host::Snapshot& snapshot, const Sink& sink) {
    while (!dues_.empty() && dues_.front().at <= snapshot.t) {
        std::ranges::pop_heap(dues_, later<Due, Due>);
        const auto index = dues_.back().entry;
        dues_.pop_back();
        on_due(snapshot, index, sink);
        schedule(index);
    }
}

// An event that was read already may be newer than the copied value. Times do not show it: an event has the
// time at which its bytes arrived.
void SampleSelector::see(Entry& entry, const host::Snapshot& snapshot) {
    TAKT_ASSERT(entry.slot.value < snapshot.values.size());
    if (entry.seen.events > snapshot.first_newer_event) return;
    const auto& slot = snapshot.values[entry.slot.value];
    entry.seen = {slot.value,   slot.quality, slot.reason,
                  slot.good_at, snapshot.t,   snapshot.first_newer_event};
}

void SampleSelector::on_due(const host::Snapshot& snapshot, std::size_t index, const Sink& sink) {
    const Instant t = snapshot.t;
    auto& entry = entries_[index];
    see(entry, snapshot);
    const bool ever_read = entry.seen.quality != value::Quality::never_read;
    const auto& policy = entry.policy;
    if (entry.next_period <= t) {
        if (ever_read) deliver(entry, t, SampleCause::period, {}, sink);
        const auto missed = (t - entry.next_period) / policy.period;
        entry.next_period += (missed + 1) * policy.period;
    }
    if (policy.heartbeat > Duration{} && entry.delivered_at + policy.heartbeat <= t) {
        if (ever_read) deliver(entry, t, SampleCause::heartbeat, {}, sink);
        entry.delivered_at = t;  // also without a sample: the next one is due a heartbeat later
    }
}

void SampleSelector::deliver_current(const host::Snapshot& snapshot, const Sink& sink, bool retained_only) {
    for (auto& entry : entries_) {
        if (retained_only && !entry.policy.retained) continue;
        see(entry, snapshot);
        if (entry.seen.quality == value::Quality::never_read) continue;
        deliver(entry, snapshot.t, SampleCause::current, {}, sink);
    }
}

}  // namespace takt::publish
