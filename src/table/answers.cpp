// The effects of an outcome on values, devices and status items.
#include <algorithm>
#include <utility>

#include "item_words.hpp"
#include "shapes.hpp"
#include "takt/table/executor.hpp"

namespace takt::table {
namespace {

bool safe_to_repeat(const View& view, const EntryRecord& entry) {
    for (std::uint32_t m = 0; m < entry.member_count; ++m)
        if ((view.item(view.member(entry, m)).flags & ItemRecord::kSafeToRepeat) == 0) return false;
    return true;
}

}  // namespace

bus::OutcomeStatus Executor::note_outcome(const bus::Outcome& outcome, std::uint32_t index) {
    const auto ended = bus::status_of(outcome);
    auto& state = devices_[index];
    state.in_flight = false;
    const bool early_probe = std::exchange(state.probed_early, false);
    if (engine_.config().framing != wire::Framing::tcp)
        state.times.step.on_outcome(outcome, state.times.in_order);
    if (outcome.status == bus::Status::timeout) state.times.on_missing();
    if (!state.enabled || ended.status == StatusCode::link_lost) return ended;
    if (ended.answered) note_delay(outcome, state);
    if (ended.answered) {
        if (state.health.answered()) restart_device(outcome.ended_at, index, true);
        if (state.away) restore_statuses(index);
    } else if (early_probe) {
        // It cost the other devices no time: the back-off stays as it is.
    } else if (state.health.failed(outcome.ended_at)) {
        degrade_device(index, StatusCode::not_answering, true);
        if (state.has_reads) drop_triggers(index);
    }
    return ended;
}

void Executor::note_delay(const bus::Outcome& outcome, DeviceState& state) const {
    if (engine_.config().framing != wire::Framing::tcp && outcome.unit == kBroadcast) return;
    const bool certain = outcome.status != bus::Status::ambiguous && !engine_.remembers(outcome.unit);
    state.times.on_response(bus::response_delay(engine_.config(), outcome), certain);
}

void Executor::note_late(const bus::LateResponse& late) {
    for (std::uint32_t d = 0; d < devices_.size(); ++d) {
        if (UnitId{device(d).unit} != late.unit) continue;
        devices_[d].times.on_late(late);
        if (late.out_of_order_since) degrade_shifted(d, late.shape, *late.out_of_order_since);
    }
}

void Executor::note_surplus(const bus::SurplusFrame& frame) {
    for (std::uint32_t d = 0; d < devices_.size(); ++d)
        if (UnitId{device(d).unit} == frame.unit)
            if (const auto since = devices_[d].times.step.on_surplus(frame))
                degrade_shifted(d, frame.shape, *since);
}

// The values of responses like that one (an exception is like all of its function) that were read since.
void Executor::degrade_shifted(std::uint32_t index, const bus::AnswerShape& shape, Instant since) {
    const auto record = device(index);
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        const auto e = record.first_entry - line_.first_entry + i;
        const auto planned = entry(e);
        if (!is_read(planned) || entries_[e].last_start < since) continue;
        const auto read = read_shape(planned);
        if (read == shape || (shape.pdu_length == 0 && read.function == shape.function))
            degrade(planned, Quality::uncertain, StatusCode::ambiguous, false);
    }
}

void Executor::on_read(const bus::Outcome& outcome, std::uint32_t index) {
    const auto planned = entry(index);
    auto& state = entries_[index];
    const bool probe = !devices_[device_of(planned)].health.answering();
    const auto ended = note_outcome(outcome, device_of(planned));
    const Instant t = outcome.ended_at;
    // The return of the device has released all its reads at once. This one has just been read, or is read
    // again because its response is in doubt.
    const bool came = ended.status == StatusCode::ok || ended.status == StatusCode::ambiguous;
    if (probe && came && is_polled(planned) && state.release.next() <= t) state.release.serve(t);
    if (ended.status == StatusCode::link_lost) {
        // It is sent again, once in a row.
        if (state.by_trigger)
            state.read_triggered = true;
        else if (!outcome.sent || !std::exchange(state.link_lost, true))
            state.retry = t;
        return;
    }
    if (!devices_[device_of(planned)].enabled) return;
    if (!ended.answered) return fail_read(t, index, planned, ended.status);
    state.health.answered();
    state.link_lost = false;
    if (ended.busy)
        state.read_not_before = after(t, state.read_busy.next());
    else
        state.read_busy.reset();
    if (ended.status == StatusCode::ok)
        take_values(planned, outcome.response);
    else if (ended.status == StatusCode::ambiguous)
        read_again(t, state, planned, ended.status);
    else
        degrade(planned, Quality::bad, ended.status, false);
    set_status(index, planned, ended.status);
}

void Executor::fail_read(Instant t, std::uint32_t index, const EntryRecord& planned, StatusCode status) {
    auto& state = entries_[index];
    state.health.failed(t);
    // A read whose response broke the stream is sent again once in a row, as after a lost link.
    const bool repeats = !engine_.must_reconnect() || !std::exchange(state.link_lost, true);
    if (!devices_[device_of(planned)].health.answering()) return;
    if (!state.health.answering()) {
        degrade(planned, Quality::bad, status, true);
    } else if (repeats) {
        read_again(t, state, planned, status);
    } else {
        degrade(planned, Quality::uncertain, status, false);
    }
    set_status(index, planned, status);
}

void Executor::read_again(Instant t, EntryState& state, const EntryRecord& planned, StatusCode status) {
    degrade(planned, Quality::uncertain, status, false);
    if (state.by_trigger)
        state.read_triggered = true;
    else
        state.retry = t;
}

void Executor::take_values(const EntryRecord& planned, const wire::ResponseView& response) {
    const auto bits = response.bits();
    const auto registers = response.registers();
    for (std::uint32_t m = 0; m < planned.member_count; ++m) {
        const auto index = view_.member(planned, m);
        const auto item = view_.item(index);
        const auto words = memory_.values.subspan(item.place, words_of(item));
        if (std::size_t{item.start} - planned.start < bits.size())
            words[0] = bits[std::size_t{item.start} - planned.start];
        else if (registers.size() == planned.quantity)
            words_from(item, planned.start, registers, words);
        else {
            degrade_item(index, Quality::bad, StatusCode::unexpected_reply, false);
            continue;
        }
        auto& state = memory_.items[index];
        state.quality = Quality::good;
        state.status = 0;
        if (item.write_place == kNone) continue;
        state.read = true;
        std::copy(words.begin(), words.end(), memory_.read.begin() + item.write_place);
    }
}

void Executor::degrade_item(std::uint32_t index, Quality quality, StatusCode status, bool to_default) {
    const auto item = view_.item(index);
    if (item.read == 0 || (item.flags & ItemRecord::kUsed) == 0) return;
    auto& state = memory_.items[index];
    if (quality == Quality::uncertain && state.quality != Quality::good) quality = state.quality;
    state.quality = quality;
    state.status = number(status);
    if (to_default && (item.flags & ItemRecord::kHoldLast) == 0 &&
        (item.flags & ItemRecord::kHasDefault) != 0)
        default_words(view_, item, memory_.values.subspan(item.place, words_of(item)));
}

void Executor::degrade(const EntryRecord& planned, Quality quality, StatusCode status, bool to_default) {
    for (std::uint32_t m = 0; m < planned.member_count; ++m)
        degrade_item(view_.member(planned, m), quality, status, to_default);
}

void Executor::degrade_device(std::uint32_t index, StatusCode status, bool to_default) {
    const auto record = device(index);
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        const auto e = record.first_entry - line_.first_entry + i;
        const auto planned = entry(e);
        degrade(planned, Quality::bad, status, to_default);
        entries_[e].status = status;
    }
    put_statuses_of_device(index, status);
    set_device_status(index);
}

// Also of items that no entry holds.
void Executor::put_statuses_of_device(std::uint32_t index, StatusCode status) {
    devices_[index].away = true;
    for (std::uint32_t i = 0; i < view_.item_count(); ++i) {
        const auto item = view_.item(i);
        if (item.device != line_.first_device + index) continue;
        memory_.items[i].away = true;
        if (item.status != kNone && (item.flags & ItemRecord::kUsed) != 0) put_status(item.status, status);
    }
}

// Of a device that answers again. Variables that are polled get their status from their next read.
void Executor::restore_statuses(std::uint32_t index) {
    devices_[index].away = false;
    const auto record = device(index);
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        const auto planned = entry(record.first_entry - line_.first_entry + i);
        for (std::uint32_t m = 0; is_polled(planned) && m < planned.member_count; ++m)
            memory_.items[view_.member(planned, m)].away = false;
    }
    for (std::uint32_t i = 0; i < view_.item_count(); ++i) {
        const auto item = view_.item(i);
        if (item.device != line_.first_device + index || !memory_.items[i].away) continue;
        memory_.items[i].away = false;
        if (item.status != kNone && (item.flags & ItemRecord::kUsed) != 0)
            put_status(item.status, StatusCode{memory_.items[i].last_result});
    }
}

// Exception 6 (busy) means that the write did not execute. A write that was not sent may be sent. After every
// other failure it may have executed.
void Executor::on_written(const bus::Outcome& outcome, std::uint32_t index) {
    const auto planned = entry(index);
    auto& state = entries_[index];
    const auto& owner = devices_[device_of(planned)];
    const auto ended = note_outcome(outcome, device_of(planned));
    if (ended.status != StatusCode::link_lost) note_result(planned, ended.status, Of::sent);
    if (reachable(owner) && ended.status != StatusCode::link_lost)
        set_status(index, planned, ended.status, Of::sent);
    const bool old_read = modify_.step == Modify::Step::reading;
    if (old_read && take_register(outcome, ended.status == StatusCode::ok && reachable(owner))) return;
    const bool refused =
        ended.busy && outcome.exception == static_cast<std::uint8_t>(wire::ExceptionCode::server_device_busy);
    const bool undone = !outcome.sent || refused || (old_read && ended.transient());
    const bool unknown = ended.status != StatusCode::ok && !undone && ended.transient();
    const bool again = ended.status != StatusCode::ok &&
                       (undone || (unknown && !ended.busy && safe_to_repeat(view_, planned)));
    if (!again || !reachable(owner) ||
        !bus::attempts_left(ended.status, view_.device(planned.device).attempts, state.write_failures))
        return end_write(index);
    if (ended.busy) state.write_not_before = after(outcome.ended_at, state.write_busy.next());
    write_again(index, planned);
}

void Executor::write_again(std::uint32_t index, const EntryRecord& planned) {
    ask(index);
    entries_[index].asked = true;
    for (std::uint32_t m = 0; m < planned.member_count; ++m) {
        auto& item = memory_.items[view_.member(planned, m)];
        item.pending = item.pending || item.sending;
    }
}

bool Executor::concerns(const EntryRecord& planned, std::uint32_t item, Of of) const {
    return of == Of::all || !writes_bits(planned) || memory_.items[item].sending;
}

void Executor::set_status(std::uint32_t index, const EntryRecord& planned, StatusCode status, Of of) {
    entries_[index].status = status;
    note_result(planned, status, of);
    put_statuses(planned, status, of);
    set_device_status(device_of(planned));
}

void Executor::note_result(const EntryRecord& planned, StatusCode status, Of of) {
    for (std::uint32_t m = 0; m < planned.member_count; ++m)
        if (const auto item = view_.member(planned, m); concerns(planned, item, of))
            memory_.items[item].last_result = number(status);
}

void Executor::put_statuses(const EntryRecord& planned, StatusCode status, Of of) {
    for (std::uint32_t m = 0; m < planned.member_count; ++m) {
        const auto item = view_.member(planned, m);
        const auto local = view_.item(item).status;
        if (local != kNone && concerns(planned, item, of)) put_status(local, status);
    }
}

// The status of a device is that of its first entry that is not ok.
void Executor::set_device_status(std::uint32_t index) {
    const auto record = device(index);
    if (record.status == kNone) return;
    StatusCode status = StatusCode::ok;
    for (std::uint32_t i = 0; i < record.entry_count && status == StatusCode::ok; ++i)
        status = entries_[record.first_entry - line_.first_entry + i].status;
    put_status(record.status, status);
}

void Executor::put_status(std::uint32_t index, StatusCode status) {
    const auto item = view_.item(index);
    const auto words = memory_.values.subspan(item.place, words_of(item));
    std::fill(words.begin(), words.end(), std::uint16_t{0});
    if (type_of(item) != DataType::string && type_of(item) != DataType::float32 &&
        type_of(item) != DataType::float64)
        words[0] = number(status);
}

}  // namespace takt::table
