// Invariant: each change of a read that concerns the queue is made through change().
#include "reads/read_schedule.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

namespace takt::poll {

// ---- the reads of a plan

void ReadSchedule::add(std::size_t index, Duration period, std::optional<RateLimitedEvent> trigger) {
    if (index >= reads_.size()) reads_.resize(index + 1);
    auto& read = reads_[index];
    read.release = bus::PeriodicRelease(period);
    read.health = tables_.devices[request(index).device].health.fresh();
    if (trigger) read.trigger = HeapOptional(Triggering{.event = *trigger});
}

void ReadSchedule::set_queue(std::size_t fewest) {
    queue_.reset();
    if (tables_.requests.size() < fewest) return;
    std::vector<std::size_t> devices;
    devices.reserve(tables_.requests.size());
    for (const auto& request : tables_.requests) devices.push_back(request.device);
    queue_ = std::make_unique<ReadQueue>(devices, tables_.devices.size());
}

Duration ReadSchedule::period(std::size_t read) const {
    return request(read).plan->period.value_or(Duration::zero());
}

ReadSchedule::Read& ReadSchedule::change(std::size_t read) {
    if (queue_) queue_->touch(read);
    return reads_[read];
}

// ---- releases

void ReadSchedule::follow(Instant t, std::size_t read) {
    change(read).release.follow(after(origin_, request(read).plan->phase), t);
}

void ReadSchedule::release_at(Instant t, std::size_t read) {
    if (request(read).read->polled) change(read).release.release_at(t);
}

// All reads of a line stay on one grid: those planned for one instant meet there again.
void ReadSchedule::restart(Instant t, std::size_t device) {
    resume(device);
    for (const auto r : tables_.devices[device].requests) {
        if (!request(r).read) continue;
        follow(t, r);
        reads_[r].retry.reset();
    }
}

void ReadSchedule::resume(std::size_t device) {
    for (const auto r : tables_.devices[device].requests) {
        if (!request(r).read) continue;
        auto& read = change(r);
        read.health = tables_.devices[device].health.fresh();
        read.not_before = Instant::min();
    }
}

void ReadSchedule::release_at_once(Instant t, std::size_t device, const SplitValues& splits) {
    std::vector<std::size_t> longest_first;
    for (const auto r : tables_.devices[device].requests)
        if (request(r).read && request(r).read->polled) longest_first.push_back(r);
    std::ranges::stable_sort(longest_first, std::greater{},
                             [this](std::size_t r) { return request(r).plan->quantity; });
    std::set<std::pair<std::size_t, std::size_t>> known;  // variable, its position in the request
    for (const auto r : longest_first) {
        bool adds_variable = false;
        for (const auto v : request(r).variables) {
            const std::size_t part = splits.has(v) ? request(r).plan->start : 0;
            adds_variable |= known.emplace(v, part).second;
        }
        if (adds_variable) release_at(t, r);
    }
}

void ReadSchedule::serve_release(Instant t, std::size_t index) {
    auto& read = change(index);
    if (request(index).read->polled && read.release.next() <= t) read.release.serve(t);
}

// ---- triggers

void ReadSchedule::pull_trigger(Instant t, std::size_t index) {
    auto& read = reads_[index];
    if (read.triggered) return;
    read.triggered = true;
    read.trigger->round = last_change_;
    read.trigger->event.arrive(t, arrivals_.next());
    read.trigger->started = false;
}

bool* ReadSchedule::line_token(std::size_t read) {
    auto& trigger = *reads_[read].trigger;
    return trigger.event.bucket ? nullptr : &trigger.started;
}

// ---- the choice

bool ReadSchedule::waits(std::size_t read) const {
    return request(read).read && request(read).read->polled && !reads_[read].in_flight;
}

Instant ReadSchedule::queued_since(std::size_t read) const {
    return reads_[read].retry.value_or(reads_[read].release.next());
}

Instant ReadSchedule::released(std::size_t read) const {
    return std::max(queued_since(read), reads_[read].not_before);
}

Instant ReadSchedule::due(std::size_t read) const {
    return slowed(read) ? std::max(released(read), reads_[read].health.probe_at()) : released(read);
}

// A read that is slowed down waits from the end of its back-off.
bus::PolledRead ReadSchedule::polled(std::size_t read) const {
    const auto& job = *request(read).read;
    return {.job = transaction_id(JobKind::read, read),
            .period = *request(read).plan->period,
            .allowed = slowed(read) ? reads_[read].health.probe_wait() : job.deadline,
            .since = slowed(read) ? due(read) : queued_since(read),
            .last_start = job.last_start,
            .slowed = slowed(read),
            .rank = job.rank,
            .position = read};
}

bool ReadSchedule::any_due(Instant t, std::size_t device) const {
    return std::ranges::any_of(tables_.devices[device].requests, [&](std::size_t r) {
        return waits(r) && period(r) > Duration::zero() && due(r) <= t;
    });
}

std::optional<std::size_t> ReadSchedule::oldest(std::size_t device) const {
    std::optional<std::size_t> found;
    for (const auto r : tables_.devices[device].requests) {
        if (!request(r).read) continue;
        if (!found || request(r).read->last_start < request(*found).read->last_start) found = r;
    }
    return found;
}

Instant ReadSchedule::last_start(std::size_t device) const {
    Instant last = Instant::min();
    for (const auto r : tables_.devices[device].requests)
        if (request(r).read) last = std::max(last, request(r).read->last_start);
    return last;
}

// ---- the choice with a queue

std::optional<QueueEntry> ReadSchedule::entry(Instant t, std::size_t read,
                                              const bus::Arbiter& arbiter) const {
    if (!waits(read)) return std::nullopt;
    QueueEntry entry{.due = due(read)};
    if (entry.due > t) return entry;
    const bus::PolledRead state = polled(read);
    entry.priority = arbiter.polled(t, state).priority();
    entry.changes = arbiter.changes_at(t, state);
    return entry;
}

void ReadSchedule::settle(Instant t, const bus::Arbiter& arbiter) {
    queue_->settle(t, [&](std::size_t read) { return entry(t, read, arbiter); });
}

// ---- transactions

ReadCause ReadSchedule::start(Instant t, std::size_t index, bool by_trigger) {
    auto& read = change(index);
    read.in_flight = true;
    read.by_trigger = by_trigger;
    read.round = t;
    if (by_trigger) {
        read.triggered = false;
        return ReadCause::trigger;
    }
    // A repetition that comes so late that the next release is due serves that one too.
    const bool repeats = std::exchange(read.retry, std::nullopt).has_value();
    const bool due = request(index).read->polled && t >= read.release.next();
    if (due) {
        read.skipped += read.release.serve(t);
        read.round = read.release.last();
    }
    return repeats ? ReadCause::repetition : due ? ReadCause::release : ReadCause::probe;
}

void ReadSchedule::ended(std::size_t read) {
    change(read).in_flight = false;
}

void ReadSchedule::again(Instant t, std::size_t index) {
    auto& read = change(index);
    if (read.by_trigger)
        read.triggered = read.trigger->event.admitted = true;
    else
        read.retry = t;
}

void ReadSchedule::answered(Instant t, std::size_t index, bool busy) {
    auto& read = change(index);
    read.health.answered();
    read.closes = 0;
    read.spared = false;
    if (busy)
        hold_back(t, index);
    else
        read.busy.reset();
}

bool ReadSchedule::failed(Instant t, std::size_t read) {
    change(read).health.failed(t);
    return slowed(read);
}

bool ReadSchedule::lost_by_close(std::size_t index) {
    auto& closes = reads_[index].closes;
    closes = std::min<std::uint8_t>(closes + 1, 2);
    return closes == 1;
}

void ReadSchedule::hold_back(Instant t, std::size_t index) {
    auto& read = change(index);
    read.not_before = after(t, read.busy.next());
}

ReadRound ReadSchedule::round(std::size_t index) const {
    const auto& read = reads_[index];
    if (read.by_trigger) return {.change = read.trigger->round};
    return {.due = read.round};
}

std::optional<std::int64_t> ReadSchedule::number_of(const ReadRound& round, std::size_t index,
                                                    Duration of_value) const {
    if (round.change) return -*round.change;
    const Duration own = period(index);
    if (own == Duration::zero()) return std::nullopt;
    return (round.due - origin_) / (of_value > Duration::zero() ? of_value : own);
}

// ---- another plan, another poller

ReadSchedule ReadSchedule::take_reads(const LineTables& old) {
    ReadSchedule taken(old, arrivals_);
    taken.reads_ = std::exchange(reads_, {});
    queue_.reset();
    return taken;
}

void ReadSchedule::carry(std::size_t read, const ReadSchedule& old, std::size_t old_read) {
    change(read) = old.reads_[old_read];
}

void ReadSchedule::carry_trigger(std::size_t index, const ReadSchedule& old, std::size_t old_read) {
    auto& read = reads_[index];
    const auto& before = old.reads_[old_read];
    if (!read.triggered) read.trigger->event = before.trigger->event;
    read.triggered = read.triggered || before.triggered;
    read.trigger->round = std::max(read.trigger->round, before.trigger->round);
}

// When polling reads its variables next.
Instant ReadSchedule::next_due(std::size_t index, Instant t) const {
    if (!request(index).read || !request(index).read->polled) return kNever;
    const auto& read = reads_[index];
    return read.retry ? std::min(t, read.release.next()) : read.release.next();
}

void ReadSchedule::keep_due(Instant t, const ReadSchedule& old) {
    std::vector<Instant> was_due(tables_.variables.size(), kNever);
    for (std::size_t r = 0; r < old.reads_.size(); ++r)
        for (const auto v : old.request(r).variables) was_due[v] = std::min(was_due[v], old.next_due(r, t));
    std::vector<std::pair<Instant, std::optional<std::size_t>>> is_due(tables_.variables.size(),
                                                                       {kNever, std::nullopt});
    for (std::size_t r = 0; r < reads_.size(); ++r) {
        if (!request(r).read || !request(r).read->polled) continue;
        for (const auto v : request(r).variables)
            if (!is_due[v].second || next_due(r, t) < is_due[v].first) is_due[v] = {next_due(r, t), r};
    }
    for (std::size_t v = 0; v < is_due.size(); ++v)
        if (const auto r = is_due[v].second; r && was_due[v] < next_due(*r, t)) release_at(was_due[v], *r);
}

void ReadSchedule::take_over(const ReadSchedule& old) {
    origin_ = old.origin_;
    last_change_ = old.last_change_;
}

void ReadSchedule::take_over(std::size_t index, const ReadSchedule& old, std::size_t old_read) {
    auto& read = change(index);
    const auto& before = old.reads_[old_read];
    read.release = before.release;
    read.health = before.health;
    read.busy = before.busy;
    read.not_before = before.not_before;
    read.retry = before.retry;
    read.round = before.round;
    read.skipped = before.skipped;
}

}  // namespace takt::poll
