// Offers the requests that may be sent to the arbiter, which chooses one (takt/bus/arbiter.hpp). All are
// offered for each transaction, so that no change since the last choice is missed; of many polled reads only
// the first of each device (ready.cpp).
#include <algorithm>
#include <cstdint>
#include <utility>

#include "run.hpp"
#include "takt/base/assert.hpp"
#include "takt/bus/failure_time.hpp"

namespace takt::poll {

Bytes LinePoller::Run::transmit(Instant t) {
    if (!keep_learning(t)) return engine_.transmit(t);  // a plan swap waits for the transactions in flight
    if (engine_.can_submit()) choose(t);
    return engine_.transmit(t);
}

Instant LinePoller::Run::next_wakeup() const {
    Instant wakeup = std::min(engine_.next_wakeup(), ages_->next());
    wakeup = std::min(wakeup, periods_.next_overrun());
    if (engine_.can_submit()) wakeup = std::min(wakeup, arbiter_.wakeup());
    return std::min(wakeup, commands_.next_expiry());
}

void LinePoller::Run::wake_at(Instant t) {
    arbiter_.wake_at(t);
}

void LinePoller::Run::choose(Instant t) {
    arbiter_.begin();
    if (modify_.second_step()) return continue_modify(t);
    if (modify_.active()) return;
    if (held_) return choose_held(t);
    if (reads_.has_queue())
        consider_first(t);
    else
        consider_all(t);
#ifdef TAKT_CHECK_CHOICE
    if (reads_.has_queue()) check_choice(t);
#endif
    for (std::size_t d = 0; d < devices_.size(); ++d) consider_probe(t, d);
    commands_.for_each_startable([&](PendingCommand& command) { consider_command(t, command); });
    consider_relayed(t);
    consider_trial(t);
    consider_early_probes(t);
    if (const auto candidate = arbiter_.choose()) start(t, *candidate);
}

void LinePoller::Run::consider_all(Instant t) {
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        const auto& device = devices_[requests_[r].device];
        if (!reachable(device) || full(device)) continue;
        consider_event(t, r);
        consider_polled(t, r);
    }
}

bool LinePoller::Run::consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                               const Candidate& candidate) {
    const Instant start = std::max(due, engine_.earliest_start(unit, shape));
    arbiter_.offer(t, start, candidate);
    return start <= t;
}

// A trigger or a change.
void LinePoller::Run::consider_event(Instant t, std::size_t request) {
    if (requests_[request].read) consider_triggered(t, request);
    if (write_groups_.has(request)) consider_write(t, request);
}

void LinePoller::Run::consider_triggered(Instant t, std::size_t request) {
    if (!reads_.triggered(request)) return;
    const auto& event = reads_.event(request);
    if (!reads_.admit(t, request)) return wake_at(event.bucket->next_admission(t));
    Candidate candidate =
        candidate_of(event, transaction_id(JobKind::read, request), requests_[request].read->rank);
    candidate.by_trigger = true;
    if (const bool* const started = reads_.line_token(request); started && !*started)
        arbiter_.defer(t, candidate);
    const UnitId unit = devices_[requests_[request].device].model->address;
    consider(t, unit, shape_to_send(t, request), reads_.not_before(request), candidate);
}

bool LinePoller::Run::consider_polled(Instant t, std::size_t request) {
    if (!reads_.waits(request)) return false;
    const Instant due = reads_.due(request);
    if (due <= t && requests_[request].plan->period > Duration::zero()) arbiter_.keep_round();
    const UnitId unit = devices_[requests_[request].device].model->address;
    const auto shape =
        engine_.any_ambiguity(t) ? shape_to_send(t, request) : requests_[request].read->shape();
    const Instant start = std::max(due, engine_.earliest_start(unit, shape));
    if (start <= t)
        arbiter_.offer(t, start, arbiter_.polled(t, reads_.polled(request)));
    else
        wake_at(start);  // its priority does not matter yet
    return start <= t;
}

void LinePoller::Run::consider_write(Instant t, std::size_t request) {
    const auto& write = write_groups_[request];
    if (write.progress.awaits_read_back()) {
        const auto candidate =
            candidate_of(write.event, transaction_id(JobKind::group_write, request), write.rank);
        return consider_read_back(t, requests_[request].device, *write.read_back, candidate);
    }
    if (!write.progress.queued() || devices_[requests_[request].device].writing) return;
    if (!write_groups_.due(request) || !group_ready(t, request)) return;
    if (!write_groups_.admit(t, request)) return wake_at(write.event.bucket->next_admission(t));
    const auto& device = devices_[requests_[request].device];
    Instant due = write.not_before;
    if (!device.health.answering()) due = std::max(due, device.health.probe_at());
    if (write.kind == WriteKind::modify)
        due = std::max(due, engine_.earliest_start(device.model->address, written_shape(write.function)));
    Candidate candidate =
        candidate_of(write.event, transaction_id(JobKind::group_write, request), write.rank);
    if (!write.event.bucket && !write.token_taken) arbiter_.defer(t, candidate);
    consider(t, device.model->address, write.shape, due, candidate);
}

void LinePoller::Run::consider_command(Instant t, PendingCommand& command) {
    auto& alone = command.alone;
    const auto& device = devices_[command.device];
    if (full(device)) return;
    Candidate candidate = bus::Arbiter::event(transaction_id(JobKind::command, command.order), command.order);
    if (!command.progress.queued()) return consider_read_back(t, command.device, *alone.verify, candidate);
    if (device.writing) return;
    if (alone.bucket_of && !alone.admitted) {
        auto& bucket = *write_groups_.bucket(*alone.bucket_of);
        alone.admitted = bucket.admit(t);
        if (!alone.admitted) return wake_at(bucket.next_admission(t));
    }
    if (!alone.admitted) arbiter_.defer(t, candidate);
    Instant due = device.health.answering() ? alone.not_before : device.health.probe_at();
    if (alone.modifies)
        due = std::max(due, engine_.earliest_start(device.model->address, written_shape(alone.function)));
    consider(t, device.model->address, bus::answer_shape(alone.request.shape()), due, candidate);
}

// Events admitted at a bounded rate go by their deadline, before those without a bound.
Candidate LinePoller::Run::candidate_of(const RateLimitedEvent& event, bus::TransactionId id,
                                        std::size_t rank) const {
    if (event.bucket && event.deadline) return bus::Arbiter::event(id, *event.deadline, rank);
    return bus::Arbiter::event(id, event.order);
}

// The read that may probe the device now.
std::optional<std::size_t> LinePoller::Run::probe_of(std::size_t index) const {
    const auto& device = devices_[index];
    if (!device.health.enabled() || device.in_flight > 0 || !device.health.probed()) return std::nullopt;
    return reads_.oldest(index);
}

void LinePoller::Run::offer_probe(Instant t, const DeviceRun& device, std::size_t request, Instant since) {
    const auto& read = *requests_[request].read;
    const bus::PolledRead probed{.job = transaction_id(JobKind::read, request),
                                 .allowed = device.health.probe_wait(),
                                 .since = since,
                                 .last_start = read.last_start,
                                 .rank = request};
    consider(t, device.model->address, shape_to_send(t, request), since, arbiter_.probe(t, probed));
}

void LinePoller::Run::consider_probe(Instant t, std::size_t index) {
    const auto& device = devices_[index];
    if (const auto oldest = probe_of(index)) offer_probe(t, device, *oldest, device.health.probe_at());
}

// Probes before their back-off has passed, so that a device that returns is noticed soon. They cost the
// others nothing: no other request waits, and none is due before the probe has timed out. A command or a
// trigger that comes meanwhile waits for one frame, as for any other one (B in docs/guarantees.md).
void LinePoller::Run::consider_early_probes(Instant t) {
    if (arbiter_.best() || !engine_.idle()) return;
    const Instant next_due = arbiter_.wakeup();
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        const auto index = probe_of(d);
        if (!index) continue;
        const auto& device = devices_[d];
        const auto& request = requests_[*index];
        const Duration period = request.plan->period.value_or(Duration::zero());
        const auto from = device.health.early_probe_at(reads_.last_start(d), period);
        if (!from) continue;
        if (*from > t) {
            arbiter_.wake_at(*from);
            continue;
        }
        const Duration lost = bus::failure_time(engine_.config(), request.read->request.pdu().size(),
                                                shape_to_send(t, *index).pdu_length, device.wait);
        if (after(t, lost) > next_due) continue;
        offer_probe(t, device, *index, t);
    }
}

}  // namespace takt::poll
