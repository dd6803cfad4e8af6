// The choice of the next request: the same order as the poller's (src/poll/schedule.cpp). All candidates are
// compared for each transaction; there is no queue.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/table/executor.hpp"

namespace takt::table {
namespace {

constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kNoDeadline = std::numeric_limits<std::int64_t>::max();

constexpr std::int64_t count(Instant t) {
    return t.time_since_epoch().count();
}

// Of requests in the background; deferred events may go before each of them.
constexpr std::int64_t least_recent(Instant last_start) {
    return std::max(count(last_start), kFirst + 1);
}

bus::AnswerShape read_shape(const EntryRecord& entry) {
    const auto function = wire::Function{entry.read};
    return {entry.read, wire::response_pdu_length(function, entry.quantity)};
}

}  // namespace

bool Executor::Candidate::before(const Candidate& other) const {
    if (urgency != other.urgency) return urgency < other.urgency;
    return key != other.key ? key < other.key : place < other.place;
}

void Executor::choose(Instant t) {
    wakeup_ = kNever;
    polling_due_ = false;
    late_poll_.reset();
    std::optional<Candidate> best;
    for (std::uint32_t e = 0; e < entries_.size(); ++e) {
        const auto planned = entry(e);
        const auto& state = devices_[device_of(planned)];
        if (!reachable(state) || state.in_flight) continue;
        const UnitId unit{view_.device(planned.device).unit};
        if (planned.read != 0) consider_read(t, e, planned, unit, best);
        if (planned.write != 0) consider_write(t, e, planned, unit, best);
    }
    for (std::uint32_t d = 0; d < devices_.size(); ++d) consider_probe(t, d, best);
    if (!polling_due_) cursor_ = 0;
    if (!best) return;
    if (late_poll_ && !polling_was_last_ && best->urgency < Urgency::overdue) best = late_poll_;
    polling_was_last_ = !best->writes && !best->by_trigger;
    event_was_last_ = false;
    if (best->writes)
        start_write(t, *best);
    else
        start_read(t, *best);
}

void Executor::consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                        const Candidate& candidate, std::optional<Candidate>& best) {
    const Instant start = std::max(due, engine_.earliest_start(unit, shape));
    if (start > t) {
        wakeup_ = std::min(wakeup_, start);
        return;
    }
    if (!best || candidate.before(*best)) best = candidate;
    if (candidate.late && (!late_poll_ || candidate.before(*late_poll_))) late_poll_ = candidate;
}

Instant Executor::polling_due(const EntryState& state) {
    const Instant due = std::max(state.retry.value_or(state.release.next()), state.read_not_before);
    return state.health.answering() ? due : std::max(due, state.health.probe_at());
}

void Executor::consider_read(Instant t, std::uint32_t index, const EntryRecord& entry, UnitId unit,
                             std::optional<Candidate>& best) {
    const auto& state = entries_[index];
    const auto shape = read_shape(entry);
    if (state.read_triggered) {
        Candidate candidate{Urgency::commanded, kNoDeadline, state.read_order, index, false, true};
        if (!state.read_admitted) defer_event(t, candidate);
        consider(t, unit, shape, state.read_not_before, candidate, best);
    }
    if (!is_polled(entry)) return;
    const Instant due = polling_due(state);
    if (due <= t && entry.period > 0) polling_due_ = true;
    consider(t, unit, shape, due, polling_rank(t, index, entry), best);
}

void Executor::consider_write(Instant t, std::uint32_t index, const EntryRecord& entry, UnitId unit,
                              std::optional<Candidate>& best) {
    const auto& state = entries_[index];
    if (!(state.asked || state.write_triggered) || !group_ready(entry)) return;
    const auto& health = devices_[device_of(entry)].health;
    const Instant due =
        health.answering() ? state.write_not_before : std::max(state.write_not_before, health.probe_at());
    Candidate candidate{Urgency::commanded, kNoDeadline, state.write_order, index, true};
    if (!state.write_admitted) defer_event(t, candidate);
    consider(t, unit, {entry.write, 5}, due, candidate, best);
}

// Triggers and writes share the rate limit of the line. Those that it does not admit now wait for a moment
// without due requests: in the background every second transaction is one of them.
void Executor::defer_event(Instant t, Candidate& candidate) const {
    if (event_gate_.admits(t)) return;
    candidate.urgency = Urgency::background;
    candidate.key = event_was_last_ ? kNoDeadline : kFirst;
}

// A repetition takes no token of its own.
void Executor::note_event(Instant t, bool& admitted) {
    if (std::exchange(admitted, true)) return event_gate_.resumed(t);
    event_gate_.started(t);
    event_was_last_ = true;
}

// A probe sends the request that was sent least recently.
void Executor::consider_probe(Instant t, std::uint32_t index, std::optional<Candidate>& best) {
    const auto& state = devices_[index];
    if (!state.enabled || state.in_flight || state.health.answering() || !state.has_reads) return;
    const auto record = device(index);
    std::optional<std::uint32_t> oldest;
    for (std::uint32_t i = 0; i < record.entry_count; ++i) {
        const auto e = record.first_entry - line_.first_entry + i;
        const auto planned = entry(e);
        if (!is_read(planned)) continue;
        if (!oldest || entries_[e].last_start < entries_[*oldest].last_start) oldest = e;
    }
    const Instant allowed = after(state.health.probe_at(), state.health.probe_wait());
    const bool late = overdue(t, state.health.probe_at(), state.health.probe_wait());
    const Candidate candidate{late ? Urgency::overdue : Urgency::background,
                              late ? count(allowed) : least_recent(entries_[*oldest].last_start), *oldest,
                              *oldest};
    consider(t, UnitId{record.unit}, read_shape(entry(*oldest)), state.health.probe_at(), candidate, best);
}

// The order of equal deadlines: unit, function, start, position in the plan.
std::uint64_t Executor::rank(std::uint32_t index, const EntryRecord& entry) const {
    return std::uint64_t{view_.device(entry.device).unit} << 56 | std::uint64_t{entry.read} << 48 |
           std::uint64_t{entry.start} << 32 | index;
}

bool Executor::overdue(Instant t, Instant since, Duration allowed) const {
    return t > after(since, bus::overdue_factor(line_.utilization) * allowed);
}

Executor::Candidate Executor::polling_rank(Instant t, std::uint32_t index, const EntryRecord& entry) const {
    const auto& state = entries_[index];
    Candidate candidate{Urgency::background, least_recent(state.last_start), rank(index, entry), index};
    const bool slowed = !state.health.answering();
    if (entry.period == 0 && !slowed) return candidate;
    const Instant since = slowed ? polling_due(state) : state.retry.value_or(state.release.next());
    const Duration allowed = slowed ? state.health.probe_wait() : Duration(entry.deadline);
    const bool rounds = line_.order == 1;
    candidate.late = !slowed && t > after(since, allowed);
    if (overdue(t, since, allowed) && (!rounds || slowed)) {
        candidate.urgency = Urgency::overdue;
        candidate.key = count(state.last_start + allowed);
    } else if (!slowed) {
        const auto size = static_cast<std::uint32_t>(entries_.size());
        candidate.urgency = Urgency::polled;
        candidate.key = rounds ? 0 : allowed.count();
        if (rounds) candidate.place = (index + size - cursor_) % size;
    }
    return candidate;
}

void Executor::start_read(Instant t, const Candidate& candidate) {
    auto& state = entries_[candidate.entry];
    const auto planned = entry(candidate.entry);
    state.by_trigger = candidate.by_trigger;
    state.last_start = t;
    if (candidate.by_trigger) {
        state.read_triggered = false;
    } else {
        cursor_ = candidate.entry + 1;
        if (state.retry)
            state.retry.reset();
        else if (is_polled(planned) && t >= state.release.next())
            state.release.serve(t);
    }
    const auto request = wire::prepare(
        wire::ReadRequest{wire::Function{planned.read}, DataAddress{planned.start}, planned.quantity});
    TAKT_ASSERT(request);  // the view keeps the limits of its functions
    submit(t, planned, candidate, *request);
}

void Executor::start_write(Instant t, const Candidate& candidate) {
    auto& state = entries_[candidate.entry];
    const auto planned = entry(candidate.entry);
    const auto request = write_request(planned);
    state.asked = state.write_triggered = false;
    if (request) {
        submit(t, planned, candidate, *request);
        return;
    }
    state.write_failures = 0;
    state.write_busy.reset();
    state.write_not_before = Instant::min();
    wakeup_ = std::min(wakeup_, t);
}

void Executor::submit(Instant t, const EntryRecord& planned, const Candidate& candidate,
                      const wire::PreparedRequest& request) {
    const auto record = view_.device(planned.device);
    auto& state = entries_[candidate.entry];
    if (candidate.writes) note_event(t, state.write_admitted);
    if (candidate.by_trigger) note_event(t, state.read_admitted);
    devices_[device_of(planned)].in_flight = true;
    const auto taken =
        engine_.submit(t, {.id = std::uint64_t{candidate.entry} << 1 | (candidate.writes ? 1U : 0U),
                           .unit = UnitId{record.unit},
                           .request = request,
                           .wait = Duration(record.wait),
                           .late_limit = Duration(record.response_timeout)});
    TAKT_ASSERT(taken);
}

}  // namespace takt::table
