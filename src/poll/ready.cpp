// The choice among many polled reads: only the first of each device is compared (ReadSchedule::queue) instead
// of all (consider_all). The result is the same; test builds check this at every choice (TAKT_CHECK_CHOICE).
#include <algorithm>
#include <limits>
#include <utility>

#include "run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

#ifdef TAKT_CHECK_CHOICE
constexpr std::size_t kFewRequests = 0;
#else
constexpr std::size_t kFewRequests = 16;  // comparing so many is as fast as keeping a queue
#endif

}  // namespace

// In rounds by address every priority changes with every choice: no queue. Such lines are slow
// (docs/specification.md, section 2).
void LinePoller::Run::keep_queue() {
    const bool rounds = line_.order == model::PollOrder::address;
    reads_.set_queue(rounds ? std::numeric_limits<std::size_t>::max() : kFewRequests + 1);
    eventful_ = reads_.has_queue() ? EventfulRequests(requests_.size()) : EventfulRequests();
}

// When any device may be sent a request. No late response delays a broadcast, which has no response.
Instant LinePoller::Run::line_free() const {
    return engine_.earliest_start(UnitId{0}, {});
}

// A trigger's read waits, a value or a command is to be written, or a write is not settled.
bool LinePoller::Run::eventful(std::size_t request) const {
    if (requests_[request].read && reads_.triggered(request)) return true;
    return write_groups_.has(request) &&
           (write_groups_.due(request) || !write_groups_[request].progress.queued());
}

// Call it wherever a request may become eventful.
void LinePoller::Run::note_event(std::size_t request) {
    if (reads_.has_queue() && eventful(request)) eventful_.add(request);
}

void LinePoller::Run::consider_first(Instant t) {
    reads_.settle(t, arbiter_);
    eventful_.remove_unless([this](std::size_t request) { return eventful(request); });
    for (const auto r : eventful_.all()) {
        const auto& device = devices_[requests_[r].device];
        if (reachable(device) && !full(device)) consider_event(t, r);
    }
    const Instant free = line_free();
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (reachable(devices_[d]) && !full(devices_[d])) consider_first_of(t, free, d);
}

// Late responses may delay some requests of a device and not others: the first one that they do not delay is
// compared.
void LinePoller::Run::consider_first_of(Instant t, Instant free, std::size_t device) {
    wake_at(std::max(reads_.next_wakeup(device), free));
    if (!reads_.any_ready(device)) return;
    if (free > t) return wake_at(free);
    reads_.visit_ready(device, [&](std::size_t request) { return !consider_polled(t, request); });
}

#ifdef TAKT_CHECK_CHOICE
// The side effects of the second comparison (token buckets, reports) are idempotent.
void LinePoller::Run::check_choice(Instant t) {
    bus::Arbiter first = arbiter_;
    arbiter_.begin();
    consider_all(t);
    std::swap(first, arbiter_);  // the queue knows the first of each device only
    const auto& chosen = arbiter_.best();
    const auto& best = first.best();
    TAKT_ASSERT(chosen.has_value() == best.has_value());
    if (best)
        TAKT_ASSERT(chosen->job == best->job && chosen->by_trigger == best->by_trigger &&
                    chosen->priority() == best->priority());
    const Instant wakeup = arbiter_.wakeup();
    if (!best)
        TAKT_ASSERT(wakeup > t && wakeup <= first.wakeup() &&
                    (wakeup == kNever) == (first.wakeup() == kNever));
}
#endif

}  // namespace takt::poll
