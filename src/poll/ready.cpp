// The choice among many polled reads: only the first of each device is compared (ReadQueue) instead of all
// (consider_all). The result is the same; test builds check this at every choice (TAKT_CHECK_CHOICE).
#include <algorithm>
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
void LinePoller::Run::make_queue() {
    queue_.reset();
    eventful_.clear();
    if (requests_.size() <= kFewRequests || line_.order == model::PollOrder::address) return;
    std::vector<std::size_t> devices;
    devices.reserve(requests_.size());
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        devices.push_back(requests_[r].device);
        if (write_groups_.has(r) || requests_[r].plan->read_trigger) eventful_.push_back(r);
    }
    queue_ = std::make_unique<ReadQueue>(devices, devices_.size());
}

// When any device may be sent a request. No late response delays a broadcast, which has no response.
Instant LinePoller::Run::line_free() const {
    return engine_.earliest_start(UnitId{0}, {});
}

void LinePoller::Run::touch(std::size_t request) {
    if (queue_) queue_->touch(request);
}

std::optional<QueueEntry> LinePoller::Run::entry(Instant t, std::size_t index) const {
    const auto& request = requests_[index];
    if (!request.read || !request.read->polled || request.read->in_flight) return std::nullopt;
    QueueEntry entry{.due = request.read->polling_due()};
    if (entry.due > t) return entry;
    const bus::PolledRead polled = polled_read(index);
    entry.priority = arbiter_.polled(t, polled).priority();
    entry.changes = arbiter_.changes_at(t, polled);
    return entry;
}

void LinePoller::Run::consider_first(Instant t) {
    queue_->settle(t, [&](std::size_t request) { return entry(t, request); });
    for (const auto r : eventful_) {
        const auto& device = devices_[requests_[r].device];
        if (reachable(device) && !full(device)) consider_event(t, r);
    }
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (reachable(devices_[d]) && !full(devices_[d])) consider_first_of(t, d);
}

// Late responses may delay some requests of a device and not others: then all due reads are compared.
void LinePoller::Run::consider_first_of(Instant t, std::size_t device) {
    wake_at(std::max(queue_->next_due(device), line_free()));
    const auto first = queue_->first(device);
    if (!first) return;
    if (const Instant start = line_free(); start > t) return wake_at(start);
    const UnitId unit = devices_[device].model->address;
    if (engine_.earliest_start(unit, requests_[*first].read->shape()) <= t) return consider_polled(t, *first);
    queue_->for_each_due(device, [&](std::size_t request) { consider_polled(t, request); });
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
