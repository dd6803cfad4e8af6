// Offers the requests that may be sent to the arbiter, as the poller does (src/poll/line/request_offers.hpp).
// All are offered for each transaction; there is no queue.
#include <algorithm>
#include <cstdint>

#include "shapes.hpp"
#include "takt/base/assert.hpp"
#include "takt/bus/failure_time.hpp"
#include "takt/table/executor.hpp"

namespace takt::table {
namespace {

constexpr bool kWrites = true;
constexpr std::size_t kReadRequestLength = 5;  // of the PDU

/// The engine's id of a transaction, and the arbiter's job.
constexpr bus::TransactionId id_of(std::uint32_t entry, bool writes) {
    return std::uint64_t{entry} << 1 | (writes ? 1U : 0U);
}

}  // namespace

void Executor::choose(Instant t) {
    arbiter_.begin();
    if (modify_.step == Modify::Step::writing) return continue_modify(t);
    for (std::uint32_t e = 0; e < entries_.size(); ++e) {
        const auto planned = entry(e);
        const auto& state = devices_[device_of(planned)];
        if (!reachable(state) || state.in_flight) continue;
        const UnitId unit{view_.device(planned.device).unit};
        if (planned.read != 0) consider_read(t, e, planned, unit);
        if (planned.write != 0) consider_write(t, e, planned, unit);
    }
    for (std::uint32_t d = 0; d < devices_.size(); ++d) consider_probe(t, d);
    consider_early_probes(t);
    const auto chosen = arbiter_.choose();
    if (!chosen) return;
    arbiter_.started(*chosen);
    if (is_write(chosen->job))
        start_write(t, entry_of(chosen->job));
    else
        start_read(t, entry_of(chosen->job), chosen->by_trigger);
}

void Executor::consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                        const bus::Candidate& candidate) {
    arbiter_.offer(t, std::max(due, engine_.earliest_start(unit, shape)), candidate);
}

Instant Executor::polling_due(const EntryState& state) {
    const Instant due = std::max(state.retry.value_or(state.release.next()), state.read_not_before);
    return state.health.answering() ? due : std::max(due, state.health.probe_at());
}

void Executor::consider_read(Instant t, std::uint32_t index, const EntryRecord& entry, UnitId unit) {
    const auto& state = entries_[index];
    const auto shape = read_shape(entry);
    const Instant in_step = devices_[device_of(entry)].times.step.earliest(t, shape);
    if (state.read_triggered) {
        auto candidate = bus::Arbiter::event(id_of(index, !kWrites), state.read_order);
        candidate.by_trigger = true;
        if (!state.read_admitted) arbiter_.defer(t, candidate);
        consider(t, unit, shape, std::max(state.read_not_before, in_step), candidate);
    }
    if (!is_polled(entry)) return;
    const Instant due = polling_due(state);
    if (due <= t && entry.period > 0) arbiter_.keep_round();
    consider(t, unit, shape, std::max(due, in_step), arbiter_.polled(t, polled_read(index, entry)));
}

void Executor::consider_write(Instant t, std::uint32_t index, const EntryRecord& entry, UnitId unit) {
    const auto& state = entries_[index];
    if (!(state.asked || state.write_triggered) || !group_ready(state, entry)) return;
    const auto& health = devices_[device_of(entry)].health;
    Instant due =
        health.answering() ? state.write_not_before : std::max(state.write_not_before, health.probe_at());
    if (modifies(entry)) due = std::max(due, engine_.earliest_start(unit, written_shape(entry)));
    auto candidate = bus::Arbiter::event(id_of(index, kWrites), state.write_order);
    if (!state.write_admitted) arbiter_.defer(t, candidate);
    const auto first = read_before(entry);
    consider(t, unit,
             modifies(entry) ? bus::answer_shape(first.function, first.quantity) : written_shape(entry), due,
             candidate);
}

// The request that probes a device that does not answer: the one that was sent least recently.
std::optional<std::uint32_t> Executor::probe_of(std::uint32_t index) const {
    const auto& state = devices_[index];
    std::optional<std::uint32_t> oldest;
    if (!state.enabled || state.in_flight || state.health.answering()) return oldest;
    const auto record = device(index);
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        const auto e = record.first_entry - line_.first_entry + i;
        const auto planned = entry(e);
        if (!is_read(planned)) continue;
        if (!oldest || entries_[e].last_start < entries_[*oldest].last_start) oldest = e;
    }
    return oldest;
}

void Executor::offer_probe(Instant t, std::uint32_t index, Instant since) {
    const auto planned = entry(index);
    const auto& health = devices_[device_of(planned)].health;
    const bus::PolledRead probed{.job = id_of(index, !kWrites),
                                 .allowed = health.probe_wait(),
                                 .since = since,
                                 .last_start = entries_[index].last_start,
                                 .rank = index};
    const UnitId unit{view_.device(planned.device).unit};
    consider(t, unit, read_shape(planned), since, arbiter_.probe(t, probed));
}

void Executor::consider_probe(Instant t, std::uint32_t index) {
    if (const auto oldest = probe_of(index)) offer_probe(t, *oldest, devices_[index].health.probe_at());
}

// Probes before their back-off has passed: see the poller.
void Executor::consider_early_probes(Instant t) {
    if (arbiter_.best() || !engine_.idle()) return;
    const Instant next_due = arbiter_.wakeup();
    for (std::uint32_t d = 0; d < devices_.size(); ++d) {
        const auto index = probe_of(d);
        if (!index) continue;
        const auto planned = entry(*index);
        const auto from = devices_[d].health.early_probe_at(last_read(d), Duration(planned.period));
        if (!from) continue;
        if (*from > t) {
            arbiter_.wake_at(*from);
            continue;
        }
        const auto response = wire::response_pdu_length(wire::Function{planned.read}, planned.quantity);
        const Duration lost =
            bus::failure_time(engine_.config(), kReadRequestLength, response, Duration(device(d).wait));
        if (after(t, lost) <= next_due) offer_probe(t, *index, t);
    }
}

Instant Executor::last_read(std::uint32_t index) const {
    const auto record = device(index);
    Instant last = Instant::min();
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        const auto e = record.first_entry - line_.first_entry + i;
        if (is_read(entry(e))) last = std::max(last, entries_[e].last_start);
    }
    return last;
}

// Entries are in the order of the plan, which breaks ties.
bus::PolledRead Executor::polled_read(std::uint32_t index, const EntryRecord& entry) const {
    const auto& state = entries_[index];
    const bool slowed = !state.health.answering();
    return {.job = id_of(index, !kWrites),
            .period = Duration(entry.period),
            .allowed = slowed ? state.health.probe_wait() : Duration(entry.deadline),
            .since = slowed ? polling_due(state) : state.retry.value_or(state.release.next()),
            .last_start = state.last_start,
            .slowed = slowed,
            .rank = index,
            .position = index};
}

void Executor::start_read(Instant t, std::uint32_t index, bool by_trigger) {
    auto& state = entries_[index];
    const auto planned = entry(index);
    state.by_trigger = by_trigger;
    state.last_start = t;
    auto& owner = devices_[device_of(planned)];
    owner.probed_early = owner.health.read_started(t, Duration(planned.period));
    if (by_trigger) {
        state.read_triggered = false;
    } else {
        arbiter_.advance_round(index);
        state.retry.reset();
        if (is_polled(planned) && t >= state.release.next()) state.release.serve(t);
    }
    const auto request = wire::prepare(
        wire::ReadRequest{wire::Function{planned.read}, DataAddress{planned.start}, planned.quantity});
    TAKT_ASSERT(request);  // the view keeps the limits of its functions
    if (by_trigger) arbiter_.event_started(t, state.read_admitted);
    submit(t, planned, id_of(index, !kWrites), *request);
}

void Executor::start_write(Instant t, std::uint32_t index) {
    auto& state = entries_[index];
    const auto planned = entry(index);
    if (writes_bits(planned)) choose_bits(state, planned);
    const auto request = first_request(planned);
    state.asked = state.write_triggered = false;
    if (!request) {
        end_write(index);
        return arbiter_.wake_at(t);
    }
    if (modifies(planned)) modify_ = {.step = Modify::Step::reading, .entry = index};
    arbiter_.event_started(t, state.write_admitted);
    submit(t, planned, id_of(index, kWrites), *request);
}

// The second step of a read-modify-write.
void Executor::continue_modify(Instant t) {
    const auto index = modify_.entry;
    const auto planned = entry(index);
    const UnitId unit{view_.device(planned.device).unit};
    if (!reachable(devices_[device_of(planned)])) {
        modify_.step = Modify::Step::none;
        end_write(index);
        return arbiter_.wake_at(t);
    }
    const Instant start = engine_.earliest_start(unit, written_shape(planned));
    if (start > t) return arbiter_.wake_at(start);
    const auto request = bits_request(planned);
    TAKT_ASSERT(request);  // the view keeps the functions of such an entry
    modify_.step = Modify::Step::none;
    arbiter_.event_started(t, entries_[index].write_admitted);
    submit(t, planned, id_of(index, kWrites), *request);
}

void Executor::end_write(std::uint32_t index) {
    auto& state = entries_[index];
    state.write_failures = 0;
    state.write_admitted = false;
    state.write_busy.reset();
    state.write_not_before = Instant::min();
}

void Executor::submit(Instant t, const EntryRecord& planned, bus::TransactionId id,
                      const wire::PreparedRequest& request) {
    const auto record = view_.device(planned.device);
    devices_[device_of(planned)].in_flight = true;
    bus::Transaction transaction{
        .id = id, .unit = UnitId{record.unit}, .request = request, .wait = Duration(record.wait)};
    devices_[device_of(planned)].times.set(transaction, Duration(record.response_timeout));
    const auto taken = engine_.submit(t, transaction);
    TAKT_ASSERT(taken);
}

}  // namespace takt::table
