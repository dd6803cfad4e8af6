// The event ring. Event n is at index (n - 1) % size and is overwritten by event n + size. A cursor holds the
// number of the next event to read. If that event is overwritten, the cursor jumps to the oldest one and
// counts the difference as missed. So a slow reader delays neither the owner nor other readers.
//
// Dead band: a value is compared with the value of the slot's last event, not with its previous value. So a
// slow drift is reported once it exceeds the dead band. A change of quality or reason is always reported.
#include "takt/value/store.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "takt/base/assert.hpp"

namespace takt::value {
namespace {

std::optional<double> numeric_value(const Value& value) {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*u);
    if (const auto* d = std::get_if<double>(&value); d && std::isfinite(*d)) return *d;
    return std::nullopt;
}

bool moved(const Value& from, const Value& to, double dead_band) {
    if (same(from, to)) return false;
    const auto a = numeric_value(from);
    const auto b = numeric_value(to);
    return !a || !b || !(std::abs(*b - *a) <= dead_band);
}

}  // namespace

Store::Store(std::vector<SlotInfo> slots, std::size_t event_capacity)
    : infos_(std::move(slots)),
      slots_(infos_.size()),
      reported_(infos_.size()),
      by_name_(infos_.size()),
      events_(event_capacity) {
    TAKT_ASSERT(event_capacity > 0);
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        slots_[i].value = reported_[i].value = infos_[i].initial;
        if (infos_[i].local && !infos_[i].service) slots_[i].quality = Quality::good;
    }
    std::iota(by_name_.begin(), by_name_.end(), 0U);
    std::sort(by_name_.begin(), by_name_.end(),
              [&](auto a, auto b) { return infos_[a].name < infos_[b].name; });
}

const SlotInfo& Store::info(SlotId id) const {
    TAKT_ASSERT(id.value < infos_.size());
    return infos_[id.value];
}

const Slot& Store::operator[](SlotId id) const {
    TAKT_ASSERT(id.value < slots_.size());
    return slots_[id.value];
}

std::optional<SlotId> Store::find(std::string_view name) const {
    const auto found = std::lower_bound(by_name_.begin(), by_name_.end(), name,
                                        [&](auto id, auto text) { return infos_[id].name < text; });
    if (found == by_name_.end() || infos_[*found].name != name) return std::nullopt;
    return SlotId{*found};
}

void Store::apply(Instant t, std::span<const Update> updates) {
    ++last_batch_;
    for (const auto& update : updates) {
        TAKT_ASSERT(update.slot.value < slots_.size());
        auto& slot = slots_[update.slot.value];
        const bool graded = slot.quality != update.quality || slot.reason != update.reason;
        if (update.value) slot.value = *update.value;
        slot.quality = update.quality;
        slot.reason = update.reason;
        slot.batch = last_batch_;
        const auto good_before = slot.sampled_at;
        if (update.quality == Quality::good) {
            slot.good_at = t;
            slot.sampled_at = update.sampled_at.value_or(t);
        }
        if (graded ||
            moved(reported_[update.slot.value].value, slot.value, infos_[update.slot.value].dead_band))
            report(t, update.slot, good_before);
    }
}

void Store::carry_over(SlotId id, const Slot& slot) {
    TAKT_ASSERT(id.value < slots_.size());
    slots_[id.value] = slot;
    slots_[id.value].batch = 0;
    reported_[id.value].value = slot.value;
}

void Store::want(SlotId id, const Value& value) {
    TAKT_ASSERT(id.value < slots_.size());
    slots_[id.value].wanted = value;
}

void Store::report(Instant t, SlotId id, std::optional<Instant> good_before) {
    const auto& slot = slots_[id.value];
    auto& event = events_[last_sequence_ % events_.size()];
    event.sequence = ++last_sequence_;
    event.batch = slot.batch;
    auto& before = reported_[id.value];
    before = {slot.value, std::max(before.t, t)};
    event.t = before.t;
    event.slot = id;
    event.value = slot.value;
    event.quality = slot.quality;
    event.reason = slot.reason;
    event.good_at = slot.good_at;
    event.sampled_at = slot.sampled_at;
    event.good_before = good_before;
}

const Event* Store::next_event(EventCursor& cursor) const {
    const std::uint64_t oldest = last_sequence_ < events_.size() ? 1 : last_sequence_ - events_.size() + 1;
    if (cursor.next < oldest) {
        cursor.missed += oldest - cursor.next;
        cursor.next = oldest;
    }
    if (cursor.next > last_sequence_) return nullptr;
    return &events_[(cursor.next++ - 1) % events_.size()];
}

}  // namespace takt::value
