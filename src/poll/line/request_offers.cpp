#include "line/request_offers.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "line/transfer.hpp"
#include "takt/base/assert.hpp"
#include "takt/bus/failure_time.hpp"
#include "writes/modify_sequence.hpp"

namespace takt::poll {
namespace {

#ifdef TAKT_CHECK_CHOICE
constexpr std::size_t kFewRequests = 0;
#else
constexpr std::size_t kFewRequests = 16;  // comparing so many is as fast as keeping a queue
#endif

// Events admitted at a bounded rate go by their deadline, before those without a bound.
Candidate candidate_of(const RateLimitedEvent& event, bus::TransactionId id, std::size_t rank) {
    if (event.bucket && event.deadline) return bus::Arbiter::event(id, *event.deadline, rank);
    return bus::Arbiter::event(id, event.order);
}

}  // namespace

// In rounds by address every priority changes with every choice: no queue. Such lines are slow
// (docs/specification.md, section 2).
void RequestOffers::set_requests() {
    parts_.reads.set_queue(rounds_ ? std::numeric_limits<std::size_t>::max() : kFewRequests + 1);
    eventful_ =
        parts_.reads.has_queue() ? EventfulRequests(parts_.tables.requests.size()) : EventfulRequests();
}

// A trigger's read waits, a value or a command is to be written, or a write is not settled.
bool RequestOffers::eventful(std::size_t index) const {
    const auto& groups = parts_.write_groups;
    if (request(index).read && parts_.reads.triggered(index)) return true;
    return groups.has(index) && (groups.due(index) || !groups[index].progress.queued());
}

void RequestOffers::note_event(std::size_t index) {
    if (parts_.reads.has_queue() && eventful(index)) eventful_.add(index);
}

// ---- offers

void RequestOffers::offer_requests(Instant t) {
    if (parts_.reads.has_queue())
        offer_first(t);
    else
        offer_all(t);
    check_choice(t);
    offer_probes(t);
    offer_commands(t);
}

void RequestOffers::offer_writes(Instant t) {
    for (std::size_t r = 0; r < parts_.tables.requests.size(); ++r)
        if (parts_.write_groups.has(r) && takes_more(device_of(r))) offer_write(t, r);
    offer_commands(t);
}

void RequestOffers::offer(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                          const Candidate& candidate) {
    parts_.arbiter.offer(t, std::max(due, parts_.engine.earliest_start(unit, shape)), candidate);
}

void RequestOffers::offer_all(Instant t) {
    for (std::size_t r = 0; r < parts_.tables.requests.size(); ++r) {
        if (!takes_more(device_of(r))) continue;
        offer_event(t, r);
        offer_polled(t, r);
    }
}

void RequestOffers::offer_first(Instant t) {
    parts_.reads.settle(t, parts_.arbiter);
    eventful_.remove_unless([this](std::size_t index) { return eventful(index); });
    for (const auto r : eventful_.all())
        if (takes_more(device_of(r))) offer_event(t, r);
    const Instant free = line_free();
    for (std::size_t d = 0; d < parts_.tables.devices.size(); ++d)
        if (takes_more(parts_.tables.devices[d])) offer_first_of(t, free, d);
}

// Late responses may delay some requests of a device and not others: the first one that they do not delay is
// compared.
void RequestOffers::offer_first_of(Instant t, Instant free, std::size_t device) {
    parts_.arbiter.wake_at(std::max(parts_.reads.next_wakeup(device), free));
    if (!parts_.reads.any_ready(device)) return;
    if (free > t) return parts_.arbiter.wake_at(free);
    parts_.reads.visit_ready(device, [&](std::size_t index) { return !offer_polled(t, index); });
}

// ---- one request

// A trigger or a change.
void RequestOffers::offer_event(Instant t, std::size_t index) {
    if (request(index).read) offer_triggered(t, index);
    if (parts_.write_groups.has(index)) offer_write(t, index);
}

void RequestOffers::offer_triggered(Instant t, std::size_t index) {
    auto& reads = parts_.reads;
    if (!reads.triggered(index)) return;
    const auto& event = reads.event(index);
    if (!reads.admit(t, index)) return parts_.arbiter.wake_at(event.bucket->next_admission(t));
    Candidate candidate =
        candidate_of(event, transaction_id(JobKind::read, index), request(index).read->rank);
    candidate.by_trigger = true;
    if (const bool* const started = reads.line_token(index); started && !*started)
        parts_.arbiter.defer(t, candidate);
    const auto shape = shape_to_send(t, index);
    const auto& device = device_of(index);
    const Instant due = std::max(reads.not_before(index), device.times.step.earliest(t, shape));
    offer(t, device.model->address, shape, due, candidate);
}

// @returns whether it may be sent now
bool RequestOffers::offer_polled(Instant t, std::size_t index) {
    auto& arbiter = parts_.arbiter;
    if (!parts_.reads.waits(index)) return false;
    const Instant due = parts_.reads.due(index);
    if (due <= t && request(index).plan->period > Duration::zero()) arbiter.keep_round();
    const auto shape = shape_to_send(t, index);
    const auto& device = device_of(index);
    const Instant start = std::max({due, earliest(device, shape), device.times.step.earliest(t, shape)});
    if (start <= t)
        arbiter.offer(t, start, arbiter.polled(t, parts_.reads.polled(index)));
    else
        arbiter.wake_at(start);  // its priority does not matter yet
    return start <= t;
}

void RequestOffers::offer_write(Instant t, std::size_t index) {
    auto& groups = parts_.write_groups;
    const auto& write = groups[index];
    const auto& device = device_of(index);
    Candidate candidate = candidate_of(write.event, transaction_id(JobKind::group_write, index), write.rank);
    if (write.progress.awaits_read_back()) return offer_read_back(t, device, *write.read_back, candidate);
    if (!write.progress.queued() || device.writing) return;
    if (!groups.due(index) || !groups.ready(index)) return;
    if (!groups.admit(t, index)) return parts_.arbiter.wake_at(write.event.bucket->next_admission(t));
    Instant due = write.not_before;
    if (!device.health.answering()) due = std::max(due, device.health.probe_at());
    if (write.kind == WriteKind::modify) due = std::max(due, earliest(device, written_shape(write.function)));
    if (!write.event.bucket && !write.token_taken) parts_.arbiter.defer(t, candidate);
    offer(t, device.model->address, write.shape, due, candidate);
}

void RequestOffers::offer_commands(Instant t) {
    parts_.commands.for_each_startable([&](PendingCommand& command) { offer_command(t, command); });
}

void RequestOffers::offer_command(Instant t, PendingCommand& command) {
    auto& alone = command.alone;
    const auto& device = parts_.tables.devices[command.device];
    if (full(device)) return;
    Candidate candidate = bus::Arbiter::event(transaction_id(JobKind::command, command.order), command.order);
    if (!command.progress.queued()) return offer_read_back(t, device, *alone.verify, candidate);
    if (device.writing) return;
    if (alone.bucket_of && !alone.admitted) {
        auto& bucket = *parts_.write_groups.bucket(*alone.bucket_of);
        alone.admitted = bucket.admit(t);
        if (!alone.admitted) return parts_.arbiter.wake_at(bucket.next_admission(t));
    }
    if (!alone.admitted) parts_.arbiter.defer(t, candidate);
    Instant due = device.health.answering() ? alone.not_before : device.health.probe_at();
    if (alone.modifies) due = std::max(due, earliest(device, written_shape(alone.function)));
    offer(t, device.model->address, bus::answer_shape(alone.request.shape()), due, candidate);
}

void RequestOffers::offer_read_back(Instant t, const DeviceRun& device, const ReadBack& back,
                                    Candidate candidate) {
    Instant due = back.not_before;
    if (!device.health.answering()) due = std::max(due, device.health.probe_at());
    if (candidate.key == bus::kNoDeadline) candidate.tie_break = back.order;
    offer(t, device.model->address, bus::answer_shape(back.request.shape()), due, candidate);
}

// ---- probes

// The read that may probe the device now.
std::optional<std::size_t> RequestOffers::probe_of(std::size_t index) const {
    const auto& device = parts_.tables.devices[index];
    if (!device.health.enabled() || device.in_flight > 0 || !device.health.probed()) return std::nullopt;
    return parts_.reads.oldest(index);
}

void RequestOffers::offer_probe(Instant t, std::size_t index, Instant since) {
    const auto& device = device_of(index);
    const bus::PolledRead probed{.job = transaction_id(JobKind::read, index),
                                 .allowed = device.health.probe_wait(),
                                 .since = since,
                                 .last_start = request(index).read->last_start,
                                 .rank = index};
    offer(t, device.model->address, shape_to_send(t, index), since, parts_.arbiter.probe(t, probed));
}

void RequestOffers::offer_probes(Instant t) {
    for (std::size_t d = 0; d < parts_.tables.devices.size(); ++d)
        if (const auto read = probe_of(d)) offer_probe(t, *read, parts_.tables.devices[d].health.probe_at());
}

// A device that returns is noticed soon. The probes cost the others nothing: no other request waits, and none
// is due before the probe has timed out. A command or a trigger that comes meanwhile waits for one frame, as
// for any other one (B in docs/guarantees.md).
void RequestOffers::offer_early_probes(Instant t) {
    const auto& engine = parts_.engine;
    auto& arbiter = parts_.arbiter;
    if (arbiter.best() || !engine.idle()) return;
    const Instant next_due = arbiter.wakeup();
    for (std::size_t d = 0; d < parts_.tables.devices.size(); ++d) {
        const auto read = probe_of(d);
        if (!read) continue;
        const auto& device = parts_.tables.devices[d];
        if (device.health.condition().failure == value::Reason::closed) continue;  // costs a connection
        const Duration period = request(*read).plan->period.value_or(Duration::zero());
        const auto from = device.health.early_probe_at(parts_.reads.last_start(d), period);
        if (!from) continue;
        if (*from > t) {
            arbiter.wake_at(*from);
            continue;
        }
        const Duration lost =
            bus::failure_time(engine.config(), request(*read).read->request.pdu().size(),
                              shape_to_send(t, *read).pdu_length, device.delay_learner.wait());
        if (after(t, lost) > next_due) continue;
        offer_probe(t, *read, t);
    }
}

// ---- what is sent

// No late response delays a broadcast, which has no response.
Instant RequestOffers::line_free() const {
    return parts_.engine.earliest_start(UnitId{0}, {});
}

const plan::ReadAlternative* RequestOffers::alternative_to(Instant t, std::size_t index) {
    const auto& engine = parts_.engine;
    if (!parts_.distinct_reads) return nullptr;
    const UnitId unit = device_of(index).model->address;
    const auto shape = request(index).read->shape();
    auto planned = engine.any_ambiguity(t) ? engine.ambiguity(t, unit, shape) : bus::Ambiguity::none;
    // Another length shows without a pause that the device is in step.
    if (device_of(index).times.step.earliest(t, shape) > t)
        planned = std::max(planned, bus::Ambiguity::passed);
    if (planned == bus::Ambiguity::none) return nullptr;
    return parts_.distinct_reads->choose(index, planned, [&](wire::Function read, std::uint16_t quantity) {
        return engine.ambiguity(t, unit, bus::answer_shape(read, quantity));
    });
}

bus::AnswerShape RequestOffers::shape_to_send(Instant t, std::size_t index) {
    const auto* const instead = alternative_to(t, index);
    if (!instead) return request(index).read->shape();
    return bus::answer_shape(instead->read, instead->quantity);
}

wire::PreparedRead RequestOffers::read_to_send(Instant t, std::size_t index) {
    const auto* const instead = alternative_to(t, index);
    if (parts_.distinct_reads) parts_.distinct_reads->send(index, instead);
    if (!instead) return request(index).read->request;
    return prepared({instead->read, DataAddress{instead->start}, instead->quantity});
}

// ---- the check of test builds

// Compares the choice with a queue and the choice among all. The side effects of the second comparison (token
// buckets, reports) are idempotent.
void RequestOffers::check_choice([[maybe_unused]] Instant t) {
#ifdef TAKT_CHECK_CHOICE
    if (!parts_.reads.has_queue()) return;
    auto& arbiter = parts_.arbiter;
    bus::Arbiter first = arbiter;
    arbiter.begin();
    offer_all(t);
    std::swap(first, arbiter);  // the queue knows the first of each device only
    const auto& chosen = arbiter.best();
    const auto& best = first.best();
    TAKT_ASSERT(chosen.has_value() == best.has_value());
    if (best)
        TAKT_ASSERT(chosen->job == best->job && chosen->by_trigger == best->by_trigger &&
                    chosen->priority() == best->priority());
    const Instant wakeup = arbiter.wakeup();
    if (!best)
        TAKT_ASSERT(wakeup > t && wakeup <= first.wakeup() &&
                    (wakeup == kNever) == (first.wakeup() == kNever));
#endif
}

}  // namespace takt::poll
