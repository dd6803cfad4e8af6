// Set-up, link and locals. choice.cpp chooses the next request, answers.cpp handles outcomes.
#include "takt/table/executor.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "item_words.hpp"
#include "takt/base/assert.hpp"

namespace takt::table {

using namespace std::string_view_literals;
namespace {

bool is_run(const View& view, const EntryRecord& entry) {
    if (entry.read_trigger != kNone && view.item(entry.read_trigger).burst != 0) return false;
    const auto function = wire::Function{entry.write};
    return function != wire::Function::read_write_multiple_registers &&
           (entry.flags & EntryRecord::kHasAdmission) == 0;
}

bus::Health fresh_health(const DeviceRecord& device) {
    return bus::Health(device.attempts,
                       bus::Backoff(Duration(device.backoff_first), Duration(device.backoff_limit)));
}

Result<void> enough(std::size_t there, std::size_t needed) {
    if (there >= needed) return {};
    return fail(Code::too_short, static_cast<std::int64_t>(there), static_cast<std::int64_t>(needed));
}

}  // namespace

bus::LineConfig line_config(const LineRecord& line) {
    return {.framing = wire::Framing{line.framing},
            .format = {line.baud, line.data_bits, wire::Parity{line.parity}, line.stop_bits},
            .frame_gap = Duration(line.frame_gap),
            .request_gap = Duration(line.request_gap),
            .margin = Duration(line.margin),
            .broadcast_turnaround = Duration(line.broadcast_turnaround),
            .frame_silence = Duration(line.frame_silence),
            .in_flight = 1,
            .echo = bus::Echo{line.echo}};
}

void initialise(const View& view, const Memory& memory) {
    for (std::uint32_t i = 0; i < view.item_count(); ++i) {
        const auto item = view.item(i);
        default_words(view, item, memory.values.subspan(item.place, words_of(item)));
        memory.items[i] = ItemState{};
        if (item.write_place != kNone && (item.flags & ItemRecord::kHasDefault) != 0) {
            default_words(view, item, memory.read.subspan(item.write_place, words_of(item)));
            memory.items[i].read = true;
        }
        if (item.device == kNone) memory.items[i].quality = Quality::good;
    }
}

Result<void> Executor::can_run(const View& view, std::uint32_t line, const Memory& memory,
                               const Workspace& workspace) {
    if (line >= view.line_count()) return fail(Code::not_found, std::int64_t{line});
    const auto record = view.line(line);
    TAKT_CHECK(enough(memory.values.size(), view.header().value_words));
    TAKT_CHECK(enough(memory.read.size(), view.header().write_words));
    TAKT_CHECK(enough(memory.wanted.size(), view.header().write_words));
    TAKT_CHECK(enough(memory.items.size(), view.item_count()));
    TAKT_CHECK(enough(workspace.entries.size(), record.entry_count));
    TAKT_CHECK(enough(workspace.devices.size(), record.device_count));
    for (std::uint32_t e = 0; e < record.entry_count; ++e)
        if (!is_run(view, view.entry(record.first_entry + e)))
            return fail(Code::unsupported, "entry"sv, record.first_entry + e);
    return {};
}

Executor::Executor(const View& view, std::uint32_t line, const Memory& memory, const Workspace& workspace,
                   const std::optional<bus::LineConfig>& bus, wire::TrafficObserver* observer)
    : view_(view),
      line_(view.line(line)),
      memory_(memory),
      entries_(workspace.entries.first(line_.entry_count)),
      devices_(workspace.devices.first(line_.device_count)),
      engine_(bus ? *bus : line_config(line_), observer),
      arbiter_(line_.command_burst, Duration(line_.command_interval), line_.order == 1) {
    TAKT_ASSERT(can_run(view, line, memory, workspace));
    arbiter_.set_plan(line_.utilization, entries_.size());
    set_up();
}

void Executor::set_up() {
    for (std::uint32_t d = 0; d < devices_.size(); ++d) {
        const auto record = device(d);
        devices_[d] = DeviceState{.health = fresh_health(record)};
        if (record.poll_enable != kNone)
            devices_[d].enabled = memory_.values[view_.item(record.poll_enable).place] != 0;
    }
    for (std::uint32_t e = 0; e < entries_.size(); ++e) {
        const auto record = entry(e);
        auto& state = entries_[e] = EntryState{};
        state.health = fresh_health(device(device_of(record)));
        state.release = bus::PeriodicRelease(Duration(record.period));
        if (is_read(record)) devices_[device_of(record)].has_reads = true;
    }
}

bool Executor::reachable(const DeviceState& device) const {
    return device.enabled && (device.health.answering() || !device.has_reads);
}

// Nothing is known of it any more. Its reads are due when they were due before.
void Executor::resume_device(std::uint32_t index) {
    const auto record = device(index);
    devices_[index].health = fresh_health(record);
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        auto& state = entries_[record.first_entry - line_.first_entry + i];
        state.status = StatusCode::ok;
        state.health = fresh_health(record);
        state.read_not_before = Instant::min();
    }
}

void Executor::restart_device(Instant t, std::uint32_t index, bool at_once) {
    resume_device(index);
    const auto record = device(index);
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        const auto e = record.first_entry - line_.first_entry + i;
        entries_[e].release.follow(after(epoch_, Duration(entry(e).phase)), t);
        entries_[e].retry.reset();
    }
    if (at_once) release_at_once(t, record);
}

// Reads each item once without waiting for the grid. Of entries that cover the same items, the longest is
// released.
void Executor::release_at_once(Instant t, const DeviceRecord& record) {
    const auto first = record.first_entry - line_.first_entry;
    for (std::uint32_t e = first; e < first + record.entry_count; ++e) {
        const auto planned = entry(e);
        if (is_polled(planned) && brings_news(planned, e, record)) entries_[e].release.release_at(t);
    }
}

bool Executor::brings_news(const EntryRecord& planned, std::uint32_t index,
                           const DeviceRecord& record) const {
    const auto first = record.first_entry - line_.first_entry;
    const auto goes_before = [&](const EntryRecord& other, std::uint32_t e) {
        return is_polled(other) &&
               (other.quantity != planned.quantity ? other.quantity > planned.quantity : e < index);
    };
    for (std::uint32_t m = 0; m < planned.member_count; ++m) {
        const auto item = view_.member(planned, m);
        bool known = false;
        for (std::uint32_t e = first; e < first + record.entry_count && !known; ++e) {
            const auto other = entry(e);
            known = goes_before(other, e) && has_member(other, item) &&
                    (other.start == planned.start || !in_pieces(item, record));
        }
        if (!known) return true;
    }
    return false;
}

bool Executor::has_member(const EntryRecord& planned, std::uint32_t item) const {
    for (std::uint32_t m = 0; m < planned.member_count; ++m)
        if (view_.member(planned, m) == item) return true;
    return false;
}

/// Whether a read of the device holds only a part of the item.
bool Executor::in_pieces(std::uint32_t item, const DeviceRecord& record) const {
    const auto first = record.first_entry - line_.first_entry;
    const auto sought = view_.item(item);
    const std::uint32_t end = sought.start + items_of(sought);
    for (std::uint32_t e = first; e < first + record.entry_count; ++e) {
        const auto planned = entry(e);
        const bool whole =
            sought.start >= planned.start && end <= std::uint32_t{planned.start} + planned.quantity;
        if (is_read(planned) && !whole && has_member(planned, item)) return true;
    }
    return false;
}

void Executor::on_link(Instant t, bool up) {
    engine_.on_link(t, up);
    take_outcomes();
    if (up == up_ && up) return;
    up_ = up;
    if (!up && modify_.step == Modify::Step::writing) {  // nothing was written
        modify_.step = Modify::Step::none;
        write_again(modify_.entry, entry(modify_.entry));
    }
    // Only the first link sets the origin of the schedule, as in poll::LinePoller.
    const bool first = up && !std::exchange(was_up_, was_up_ || up);
    if (first) {
        epoch_ = t;
        arbiter_.restart_round();
    }
    for (std::uint32_t d = 0; d < devices_.size(); ++d) {
        if (!devices_[d].enabled) continue;
        if (first)
            restart_device(t, d, false);
        else if (up)
            resume_device(d);
        else
            degrade_device(d, StatusCode::link_lost, true);
    }
}

void Executor::switch_device(Instant t, std::uint32_t index, bool on) {
    auto& state = devices_[index];
    if (state.enabled == on) return;
    state.enabled = on;
    if (on) {
        restart_device(t, index, true);
        return;
    }
    degrade_device(index, StatusCode::switched_off, false);
    drop_triggers(index);
}

void Executor::drop_triggers(std::uint32_t index) {
    const auto record = device(index);
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        auto& state = entries_[record.first_entry - line_.first_entry + i];
        state.read_triggered = state.write_triggered = false;
    }
}

void Executor::on_local(Instant t, std::uint32_t item, bool before, bool after) {
    for (std::uint32_t d = 0; d < devices_.size(); ++d)
        if (device(d).poll_enable == item) switch_device(t, d, after);
    if (before || !after) return;
    for (std::uint32_t e = 0; e < entries_.size(); ++e) {
        const auto record = entry(e);
        auto& state = entries_[e];
        const auto& owner = devices_[device_of(record)];
        if (!reachable(owner)) {  // the trigger is refused
            const bool pulls = (is_read(record) && record.read_trigger == item) ||
                               (record.write != 0 && record.write_trigger == item);
            if (pulls)
                put_statuses(record, !owner.enabled ? StatusCode::switched_off
                                     : up_          ? StatusCode::not_answering
                                                    : StatusCode::link_lost);
            continue;
        }
        if (record.read != 0 && record.read_trigger == item && !state.read_triggered) {
            state.read_triggered = true;
            state.read_admitted = false;
            state.read_order = ++last_order_;
        }
        if (record.write != 0 && record.write_trigger == item) {
            ask(e);
            state.write_triggered = true;
        }
    }
}

void Executor::on_bytes(Instant t, Bytes bytes) {
    engine_.on_bytes(t, bytes);
    take_outcomes();
}

void Executor::on_tick(Instant t) {
    engine_.on_tick(t);
    take_outcomes();
}

Bytes Executor::transmit(Instant t) {
    if (!stopped_ && engine_.can_submit()) choose(t);
    return engine_.transmit(t);
}

Instant Executor::next_wakeup() const {
    const Instant wakeup = engine_.next_wakeup();
    return !stopped_ && engine_.can_submit() ? std::min(wakeup, arbiter_.wakeup()) : wakeup;
}

void Executor::take_outcomes() {
    while (const auto late = engine_.take_late()) note_late(*late);
    while (const auto frame = engine_.take_surplus()) note_surplus(*frame);
    while (const auto outcome = engine_.take_outcome()) {
        const auto index = entry_of(outcome->id);
        const bool written = is_write(outcome->id);
        if (written || entries_[index].by_trigger)
            arbiter_.event_ended(std::max(outcome->ended_at, engine_.earliest_start(UnitId{0}, {})));
        if (written)
            on_written(*outcome, index);
        else
            on_read(*outcome, index);
    }
}

}  // namespace takt::table
