#include "takt/bus/arbiter.hpp"

#include <algorithm>
#include <utility>

#include "takt/bus/release.hpp"

namespace takt::bus {
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

void Arbiter::set_plan(double utilization, std::size_t positions) {
    overdue_factor_ = overdue_factor(utilization);
    positions_ = positions;
    restart_round();
}

Instant Arbiter::overdue_after(const PolledRead& read) const {
    return after(read.since, overdue_factor_ * read.allowed);
}

Candidate Arbiter::polled(Instant t, const PolledRead& read) const {
    Candidate candidate{.urgency = Urgency::background,
                        .key = least_recent(read.last_start),
                        .tie_break = read.rank,
                        .job = read.job,
                        .polling = true};
    if (read.period == Duration::zero() && !read.slowed) return candidate;
    candidate.late = !read.slowed && t > after(read.since, read.allowed);
    if (t > overdue_after(read) && (!rounds_ || read.slowed)) {
        candidate.urgency = Urgency::overdue;
        candidate.key = count(read.last_start + read.allowed);  // by last service: overdue reads take turns
    } else if (!read.slowed) {
        candidate.urgency = Urgency::polled;
        candidate.key = rounds_ ? 0 : read.allowed.count();
        if (rounds_) candidate.tie_break = (read.position + positions_ - cursor_) % positions_;
    }
    return candidate;
}

Instant Arbiter::changes_at(Instant t, const PolledRead& read) const {
    const bool ages = read.slowed || read.period > Duration::zero();
    const Instant overdue = overdue_after(read);
    return ages && t <= overdue ? after(overdue, Duration(1)) : kNever;
}

Candidate Arbiter::probe(Instant t, const PolledRead& read) const {
    const bool late = t > overdue_after(read);
    return {.urgency = late ? Urgency::overdue : Urgency::background,
            .key = late ? count(after(read.since, read.allowed)) : least_recent(read.last_start),
            .tie_break = read.rank,
            .job = read.job,
            .polling = true};
}

Candidate Arbiter::event(std::uint64_t job, std::uint64_t order) {
    return {.urgency = Urgency::commanded, .key = kNoDeadline, .tie_break = order, .job = job};
}

Candidate Arbiter::event(std::uint64_t job, Duration deadline, std::uint64_t rank) {
    return {.urgency = Urgency::commanded, .key = deadline.count(), .tie_break = rank, .job = job};
}

void Arbiter::defer(Instant t, Candidate& event) const {
    if (events_.admits(t)) return;
    event.urgency = Urgency::background;
    event.key = event_was_last_ ? kNoDeadline : kFirst;
}

void Arbiter::begin() {
    best_.reset();
    late_.reset();
    wakeup_ = kNever;
    in_round_ = false;
}

void Arbiter::offer(Instant t, Instant start, const Candidate& candidate) {
    if (start > t) return wake_at(start);
    const auto goes_before = [&candidate](const std::optional<Candidate>& other) {
        return !other || candidate.priority() < other->priority();
    };
    if (goes_before(best_)) best_ = candidate;
    if (candidate.late && goes_before(late_)) late_ = candidate;
}

std::optional<Candidate> Arbiter::choose() {
    if (!in_round_) restart_round();
    const bool polling_waits = late_ && !polling_was_last_;
    return best_ && polling_waits && best_->urgency < Urgency::overdue ? late_ : best_;
}

void Arbiter::started(const Candidate& candidate) {
    event_was_last_ = false;
    polling_was_last_ = candidate.polling;
}

// A repetition, the second step of a read-modify-write and a verification take no token of their own.
void Arbiter::event_started(Instant t, bool& admitted) {
    if (std::exchange(admitted, true)) return events_.resumed(t);
    events_.started(t);
    event_was_last_ = true;
}

}  // namespace takt::bus
