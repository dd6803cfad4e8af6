// The choice of the next request: earliest deadline first (EDF) within classes of urgency, without
// preemption. All candidates are compared for each transaction, so that no change since the last choice is
// missed; of many polled reads only the first of each device (ready.cpp).
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();

constexpr std::int64_t count(Instant t) {
    return t.time_since_epoch().count();
}

// Of requests in the background; deferred events may go before each of them.
constexpr std::int64_t least_recent(Instant last_start) {
    return std::max(count(last_start), kFirst + 1);
}

}  // namespace

Bytes LinePoller::Run::transmit(Instant t) {
    if (!keep_learning(t)) return engine_.transmit(t);  // a plan swap waits for the transactions in flight
    if (engine_.can_submit()) choose(t);
    return engine_.transmit(t);
}

Instant LinePoller::Run::next_wakeup() const {
    Instant wakeup = std::min(engine_.next_wakeup(), ages_->next());
    wakeup = std::min(wakeup, periods_.next_overrun());
    if (engine_.can_submit()) wakeup = std::min(wakeup, wakeup_);
    return std::min(wakeup, commands_.next_expiry());
}

void LinePoller::Run::wake_at(Instant t) {
    wakeup_ = std::min(wakeup_, t);
}

void LinePoller::Run::choose(Instant t) {
    wakeup_ = kNever;
    if (modify_.second_step()) return continue_modify(t);
    if (modify_.active()) return;
    polling_due_ = false;
    late_poll_.reset();
    std::optional<Candidate> best;
    if (held_) return consider_held(t, best);
    if (queue_)
        consider_first(t, best);
    else
        consider_all(t, best);
#ifdef TAKT_CHECK_CHOICE
    if (queue_) check_choice(t, best);
#endif
    for (std::size_t d = 0; d < devices_.size(); ++d) consider_probe(t, d, best);
    commands_.for_each_startable([&](PendingCommand& command) { consider_command(t, command, best); });
    consider_relayed(t, best);
    consider_trial(t, best);
    if (!polling_due_) cursor_ = 0;
    if (best) start(t, waits_for_polling(*best) ? *late_poll_ : *best);
}

// However many commands, triggers and relayed requests there are: of two transactions one at least is polling
// that is late. On a line that holds its deadlines nothing ever is.
bool LinePoller::Run::waits_for_polling(const Candidate& best) const {
    return late_poll_ && !polling_was_last_ && best.urgency < Urgency::overdue;
}

void LinePoller::Run::consider_all(Instant t, std::optional<Candidate>& best) {
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        const auto& device = devices_[requests_[r].device];
        if (!reachable(device) || full(device)) continue;
        consider_event(t, r, best);
        consider_polled(t, r, best);
    }
}

void LinePoller::Run::consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                               const Candidate& candidate, std::optional<Candidate>& best) {
    const Instant start = std::max(due, engine_.earliest_start(unit, shape));
    if (start > t) return wake_at(start);
    if (!best || candidate.before(*best)) best = candidate;
    if (candidate.late && (!late_poll_ || candidate.before(*late_poll_))) late_poll_ = candidate;
}

// A trigger or a change.
void LinePoller::Run::consider_event(Instant t, std::size_t request, std::optional<Candidate>& best) {
    if (requests_[request].read) consider_triggered(t, request, best);
    if (write_groups_.has(request)) consider_write(t, request, best);
}

void LinePoller::Run::consider_triggered(Instant t, std::size_t request, std::optional<Candidate>& best) {
    auto& read = *requests_[request].read;
    if (read.in_flight || !read.triggered) return;
    auto& event = read.trigger->event;
    if (!event.admit(t)) return wake_at(event.bucket->next_admission(t));
    Candidate candidate = commanded(event, request, read.rank);
    candidate.kind = JobKind::read;
    candidate.by_trigger = true;
    if (!event.bucket && !read.trigger->started) defer_event(t, candidate);
    const UnitId unit = devices_[requests_[request].device].model->address;
    consider(t, unit, read.shape(), read.not_before, candidate, best);
}

void LinePoller::Run::consider_polled(Instant t, std::size_t request, std::optional<Candidate>& best) {
    if (!requests_[request].read) return;
    const auto& read = *requests_[request].read;
    if (read.in_flight || !read.polled) return;
    const Instant due = read.polling_due();
    if (due <= t && requests_[request].plan->period > Duration::zero()) polling_due_ = true;
    const UnitId unit = devices_[requests_[request].device].model->address;
    consider(t, unit, read.shape(), due, polling_rank(t, request), best);
}

void LinePoller::Run::consider_write(Instant t, std::size_t request, std::optional<Candidate>& best) {
    const auto& write = write_groups_[request];
    if (write.progress.awaits_read_back()) {
        Candidate candidate = commanded(write.event, request, write.rank);
        candidate.kind = JobKind::group_write;
        return consider_read_back(t, requests_[request].device, *write.read_back, candidate, best);
    }
    if (!write.progress.queued() || devices_[requests_[request].device].writing) return;
    if (!write_groups_.due(request) || !group_ready(t, request)) return;
    if (!write_groups_.admit(t, request)) return wake_at(write.event.bucket->next_admission(t));
    const auto& device = devices_[requests_[request].device];
    Instant due = write.not_before;
    if (!device.health.answering()) due = std::max(due, device.health.probe_at());
    if (write.kind == WriteKind::modify)
        due = std::max(due, engine_.earliest_start(device.model->address, written_shape(write.function)));
    Candidate candidate = commanded(write.event, request, write.rank);
    candidate.kind = JobKind::group_write;
    if (!write.event.bucket && !write.token_taken) defer_event(t, candidate);
    consider(t, device.model->address, write.shape, due, candidate, best);
}

void LinePoller::Run::consider_command(Instant t, PendingCommand& command, std::optional<Candidate>& best) {
    auto& alone = command.alone;
    const auto& device = devices_[command.device];
    if (full(device)) return;
    Candidate candidate{Urgency::commanded, kNoDeadline, command.order, JobKind::command, command.order};
    if (!command.progress.queued())
        return consider_read_back(t, command.device, *alone.verify, candidate, best);
    if (device.writing) return;
    if (alone.bucket_of && !alone.admitted) {
        auto& bucket = *write_groups_.bucket(*alone.bucket_of);
        alone.admitted = bucket.admit(t);
        if (!alone.admitted) return wake_at(bucket.next_admission(t));
    }
    if (!alone.admitted) defer_event(t, candidate);
    Instant due = device.health.answering() ? alone.not_before : device.health.probe_at();
    if (alone.modifies)
        due = std::max(due, engine_.earliest_start(device.model->address, written_shape(alone.function)));
    consider(t, device.model->address, bus::answer_shape(alone.request.shape()), due, candidate, best);
}

// Commands, triggers and changes without a rate limit of their own share one of the line. Those that it does
// not admit now wait for a moment without due requests: in the background every second transaction is one of
// them.
void LinePoller::Run::defer_event(Instant t, Candidate& candidate) const {
    if (event_gate_.admits(t)) return;
    candidate.urgency = Urgency::background;
    candidate.key = event_was_last_ ? kNoDeadline : kFirst;
}

// Events admitted at a bounded rate go by their deadline, before those without a bound, which go in the order
// of arrival.
Candidate LinePoller::Run::commanded(const RateLimitedEvent& event, std::size_t request,
                                     std::size_t rank) const {
    Candidate candidate{
        .urgency = Urgency::commanded, .key = kNoDeadline, .tie_break = event.order, .index = request};
    if (event.bucket && event.deadline) {
        candidate.key = event.deadline->count();
        candidate.tie_break = rank;
    }
    return candidate;
}

bool LinePoller::Run::overdue(Instant t, Instant since, Duration allowed) const {
    return t > overdue_after(since, allowed);
}

Instant LinePoller::Run::overdue_after(Instant since, Duration allowed) const {
    return after(since, overdue_factor_ * allowed);
}

// A probe sends the request that was sent least recently: a request that the device never answers must not
// hide that the device is back.
void LinePoller::Run::consider_probe(Instant t, std::size_t index, std::optional<Candidate>& best) {
    const auto& device = devices_[index];
    if (!device.enabled || device.in_flight > 0 || device.health.answering() || !device.has_reads) return;
    std::optional<std::size_t> oldest;
    for (const auto r : device.requests) {
        if (!requests_[r].read) continue;
        if (!oldest || requests_[r].read->last_start < requests_[*oldest].read->last_start) oldest = r;
    }
    const auto& read = *requests_[*oldest].read;
    const Instant allowed = after(device.health.probe_at(), device.health.probe_wait());
    const bool late = overdue(t, device.health.probe_at(), device.health.probe_wait());
    const Candidate candidate{late ? Urgency::overdue : Urgency::background,
                              late ? count(allowed) : least_recent(read.last_start), *oldest, JobKind::read,
                              *oldest};
    consider(t, device.model->address, read.shape(), device.health.probe_at(), candidate, best);
}

Candidate LinePoller::Run::polling_rank(Instant t, std::size_t request) const {
    const auto& read = *requests_[request].read;
    Candidate candidate{Urgency::background, least_recent(read.last_start), read.rank, JobKind::read,
                        request};
    const bool slowed = !read.health.answering();
    if (requests_[request].plan->period == Duration::zero() && !slowed) return candidate;
    const Instant since = read.waits_since();
    const Duration allowed = slowed ? read.health.probe_wait() : read.deadline;
    const bool rounds = line_.order == model::PollOrder::address;
    candidate.late = !slowed && t > after(since, allowed);
    if (overdue(t, since, allowed) && (!rounds || slowed)) {
        candidate.urgency = Urgency::overdue;
        candidate.key = count(read.last_start + allowed);  // by last service: overdue reads take turns
    } else if (!slowed) {
        candidate.urgency = Urgency::polled;
        candidate.key = rounds ? 0 : allowed.count();
        if (rounds) candidate.tie_break = (request + requests_.size() - cursor_) % requests_.size();
    }
    return candidate;
}

}  // namespace takt::poll
