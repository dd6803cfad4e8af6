// What is sent next. All candidates are compared anew for each transaction: the line is slow, and nothing
// that changed since the last choice can be forgotten in a queue.
#include <algorithm>

#include "run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

constexpr bus::TransactionId transaction_id(JobKind kind, std::uint64_t index) {
    return index << 2 | static_cast<std::uint64_t>(kind);
}

constexpr std::int64_t count(Instant t) {
    return t.time_since_epoch().count();
}

}  // namespace

Bytes LinePoller::Run::transmit(Instant t) {
    if (engine_.can_submit()) choose(t);
    return engine_.transmit(t);
}

Instant LinePoller::Run::next_wakeup() const {
    Instant wakeup = engine_.next_wakeup();
    if (engine_.can_submit()) wakeup = std::min(wakeup, wakeup_);
    for (const auto& command : commands_)
        if (!command.in_flight) wakeup = std::min(wakeup, command.command.expires);
    return wakeup;
}

void LinePoller::Run::wake_at(Instant t) {
    wakeup_ = std::min(wakeup_, t);
}

void LinePoller::Run::choose(Instant t) {
    wakeup_ = kNever;
    polling_due_ = false;
    std::optional<Candidate> best;
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        const auto& device = devices_[requests_[r].device];
        if (!reachable(device) || device.in_flight) continue;
        if (requests_[r].read) consider_read(t, r, best);
        if (requests_[r].write) consider_write(t, r, best);
    }
    for (std::size_t d = 0; d < devices_.size(); ++d) consider_probe(t, d, best);
    for (const auto& command : commands_) {
        const auto& device = devices_[variables_[command.variable].device];
        if (command.group || command.in_flight || device.in_flight) continue;
        const Instant due = device.health.answering() ? command.not_before : device.health.probe_at();
        const Candidate candidate{Urgency::commanded, static_cast<std::int64_t>(command.order), 0,
                                  JobKind::command, command.order};
        consider(t, device.model->address, command.shape, due, candidate, best);
    }
    if (!polling_due_) cursor_ = 0;
    if (best) start(t, *best);
}

void LinePoller::Run::consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                               const Candidate& candidate, std::optional<Candidate>& best) {
    const Instant start = std::max(due, engine_.earliest_start(unit, shape));
    if (start > t)
        wake_at(start);
    else if (!best || candidate.before(*best))
        best = candidate;
}

void LinePoller::Run::consider_read(Instant t, std::size_t request, std::optional<Candidate>& best) {
    const auto& read = *requests_[request].read;
    const UnitId unit = devices_[requests_[request].device].model->address;
    if (read.triggered) {
        const Candidate candidate{
            Urgency::commanded, static_cast<std::int64_t>(read.order), 0, JobKind::read, request, true};
        consider(t, unit, read.shape, read.not_before, candidate, best);
    }
    if (!read.polled) return;
    Instant due = std::max(read.retry.value_or(read.release.next()), read.not_before);
    if (!read.health.answering()) due = std::max(due, read.health.probe_at());
    if (due <= t && requests_[request].plan->period > Duration::zero()) polling_due_ = true;
    consider(t, unit, read.shape, due, polling_rank(t, request), best);
}

void LinePoller::Run::consider_write(Instant t, std::size_t request, std::optional<Candidate>& best) {
    const auto& write = *requests_[request].write;
    if (!write.due() || !group_ready(t, request)) return;
    const auto& device = devices_[requests_[request].device];
    const Instant due =
        device.health.answering() ? write.not_before : std::max(write.not_before, device.health.probe_at());
    const Candidate candidate{Urgency::commanded, static_cast<std::int64_t>(write.order), 0,
                              JobKind::group_write, request};
    consider(t, device.model->address, write.shape, due, candidate, best);
}

// Each probe asks what was not asked for longest: one request the device never answers must not hide that it
// is back.
void LinePoller::Run::consider_probe(Instant t, std::size_t index, std::optional<Candidate>& best) {
    const auto& device = devices_[index];
    if (!device.enabled || device.in_flight || device.health.answering() || !device.has_reads) return;
    std::optional<std::size_t> oldest;
    for (const auto r : device.requests) {
        if (!requests_[r].read) continue;
        if (!oldest || requests_[r].read->last_start < requests_[*oldest].read->last_start) oldest = r;
    }
    const auto& read = *requests_[*oldest].read;
    const Instant overdue = after(device.health.probe_at(), device.health.probe_wait());
    const bool late = t > overdue;
    const Candidate candidate{late ? Urgency::overdue : Urgency::background,
                              count(late ? overdue : read.last_start), *oldest, JobKind::read, *oldest};
    consider(t, device.model->address, read.shape, device.health.probe_at(), candidate, best);
}

Candidate LinePoller::Run::polling_rank(Instant t, std::size_t request) const {
    const auto& read = *requests_[request].read;
    Candidate candidate{Urgency::background, count(read.last_start), request, JobKind::read, request};
    const bool slowed = !read.health.answering();
    if (requests_[request].plan->period == Duration::zero() && !slowed) return candidate;
    const Instant since = slowed ? read.health.probe_at() : read.retry.value_or(read.release.next());
    const Duration allowed = slowed ? read.health.probe_wait() : read.deadline;
    const bool rounds = line_.order == model::PollOrder::address;
    if (t > after(since, allowed) && (!rounds || slowed)) {
        candidate.urgency = Urgency::overdue;
        candidate.key = count(read.last_start + allowed);  // not the release: who was just served has to wait
    } else if (!slowed) {
        candidate.urgency = Urgency::polled;
        candidate.key = rounds ? 0 : allowed.count();
        if (rounds) candidate.place = (request + requests_.size() - cursor_) % requests_.size();
    }
    return candidate;
}

void LinePoller::Run::start(Instant t, const Candidate& candidate) {
    switch (candidate.kind) {
        case JobKind::read: start_read(t, candidate.index, candidate.by_trigger); return;
        case JobKind::group_write: start_group(t, candidate.index); return;
        case JobKind::command: break;
    }
    const auto command = std::find_if(commands_.begin(), commands_.end(),
                                      [&](const auto& c) { return c.order == candidate.index; });
    command->in_flight = true;
    submit(t, variables_[command->variable].device, transaction_id(JobKind::command, command->order),
           command->pdu);
}

void LinePoller::Run::start_read(Instant t, std::size_t index, bool by_trigger) {
    auto& request = requests_[index];
    auto& read = *request.read;
    read.by_trigger = by_trigger;
    read.last_start = t;
    if (by_trigger) {
        read.triggered = false;
    } else {
        cursor_ = index + 1;
        if (read.retry) {
            read.retry.reset();
        } else if (read.polled && t >= read.release.next()) {
            request.statistics.skipped += read.release.serve(t);
            const bool changed = read.meter.started(t);
            request.statistics.real_period = read.meter.real();
            request.statistics.recent_period = read.meter.recent();
            request.statistics.overrun = read.meter.overrun();
            if (changed && observer_)
                observer_->on_overrun(t, plan_.line, index, *request.plan->period, read.meter.recent());
        }
    }
    submit(t, request.device, transaction_id(JobKind::read, index), read.pdu);
}

void LinePoller::Run::start_group(Instant t, std::size_t index) {
    auto& request = requests_[index];
    auto& write = *request.write;
    const auto pdu = group_pdu(request);
    write.asked = write.triggered = false;
    write.commands = 0;
    for (auto& command : commands_)
        if (command.group == index) command.in_flight = true;
    if (pdu) {
        submit(t, request.device, transaction_id(JobKind::group_write, index), *pdu);
        return;
    }
    finish_group(t, index, value::CommandResult::refused, value::Reason::ok);
    wake_at(t);
}

void LinePoller::Run::submit(Instant t, std::size_t index, bus::TransactionId id, const wire::Pdu& pdu) {
    auto& device = devices_[index];
    device.in_flight = true;
    const auto taken = engine_.submit(t, {.id = id,
                                          .unit = device.model->address,
                                          .request = pdu,
                                          .wait = device.wait,
                                          .late_limit = device.model->response_timeout});
    TAKT_ASSERT(taken);
}

void LinePoller::Run::on_outcome(const bus::Outcome& outcome) {
    const auto kind = static_cast<JobKind>(outcome.id & 3);
    const auto index = outcome.id >> 2;
    switch (kind) {
        case JobKind::read: on_read(outcome, index); return;
        case JobKind::group_write: on_group_written(outcome, index); return;
        case JobKind::command: on_command_written(outcome, index); return;
    }
}

}  // namespace takt::poll
