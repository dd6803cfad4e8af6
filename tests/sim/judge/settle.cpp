// Settles transactions: how they ended, and the resulting state of their devices.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr Duration kAfterStandstill = std::chrono::milliseconds(1);
constexpr Duration kRemembered = std::chrono::minutes(2);

}  // namespace

// A transaction beyond its deadline has failed, unless the host was suspended.
void LineJudge::settle_passed(Instant t) {
    if (t <= stood_still_until_ + kAfterStandstill) return;
    for (Transaction& transaction : transactions_)
        if (!transaction.over && t > transaction.deadline) settle(transaction, t);
}

// No request is in flight twice. A transaction that was in flight while the host was suspended, and is beyond
// its deadline, ends when it is sent again or its device is probed.
void LineJudge::settle_claimed(Instant t, const Claim& claim) {
    const auto& sending = claim.sending;
    for (Transaction& earlier : transactions_) {
        if (earlier.over || earlier.deadline >= t || earlier.device != sending.device) continue;
        const bool same = sending.request && earlier.request == sending.request;
        const bool commanded = sending.command && std::ranges::find(earlier.commands, *sending.command) !=
                                                      earlier.commands.end();
        if (same || commanded || sending.purpose == Purpose::probe) settle(earlier, t);
    }
}

// For the judge further parts may follow a partial reception. The master already has its answer.
void LineJudge::settle_answered() {
    for (Transaction& earlier : transactions_)
        if (!earlier.over && !earlier.broadcast && earlier.answered() && !earlier.unsure())
            settle(earlier, earlier.heard_at);
}

void LineJudge::on_unsent(const Claim& claim) {
    ++devices_[claim.sending.device].possible;
    if (!claim.sending.request || *claim.sending.request >= requests_.size()) return;
    RequestState& request = requests_[*claim.sending.request];
    request.retry = request.held = true;
    request.set_bits.clear();  // those of the last attempt are given up
}

bool LineJudge::waits(const Transaction& transaction, Instant t) const {
    return may_wait(transaction, t) && !transaction.over && !transaction.heard_something &&
           transaction.deadline > t && t > stood_still_until_ + kAfterStandstill;
}

// A peer that closes after each response does so before it receives the next request. Such a close is sooner
// than any answer, and may be held against no device.
bool LineJudge::may_be_spared(const Transaction& transaction, Instant t) const {
    const auto& fastest = devices_[transaction.device].fastest;
    return transaction.is_its_read() && answers_ && (!fastest || t - transaction.start < *fastest);
}

// A close is a failure of the request that alone waited, if no other one was in flight since it was sent.
Close LineJudge::attribute(const Transaction& transaction, Instant t) const {
    const auto others = [&](auto waits) {
        return std::ranges::any_of(
            transactions_, [&](const Transaction& other) { return &other != &transaction && waits(other); });
    };
    if (transaction.joined || others([&](const auto& other) { return waits(other, t); }))
        return Close::of_several;
    const bool certain = !transaction.may_be_joined && !relayed_open_ && waits(transaction, t) &&
                         !others([&](const auto& other) { return may_wait(other, t); }) &&
                         !may_be_spared(transaction, t);
    return certain ? Close::own : Close::perhaps_own;
}

void LineJudge::settle_closed(Instant t) {
    std::vector<Transaction*> waiting;
    for (auto& each : transactions_)
        if (!each.over && !each.broadcast) waiting.push_back(&each);
    for (auto* const each : waiting)  // at its deadline it may have timed out
        each->close = each->deadline <= t ? Close::perhaps_own : attribute(*each, t);
    for (auto* const each : waiting) {
        ++recoveries_[each->close == Close::of_several ? "closed_with_several" : "closed_alone"];
        if (each->close != Close::of_several) closes_.insert(devices_[each->device].model->address.value);
        settle(*each, t);
    }
    if (relayed_open_ && relayed_to_) closes_.insert(*relayed_to_);
}

// Then it is the fault of the line. A relayed request may have met a close, too.
bool LineJudge::all_met_closes() const {
    if (closes_.empty() || (closes_.size() < 2 && !line_.relayed)) return false;
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (devices_[d].enabled && !devices_[d].may_be_dead() &&
            !closes_.contains(devices_[d].model->address.value))
            return false;
    return true;
}

// If the link was lost, nothing is known of the devices any more.
void LineJudge::perhaps_lost() {
    for (auto& device : devices_) {
        device.failures = device.probes = 0;
        device.possible = std::max(device.possible, unsigned{device.model->attempts});
        device.probe_not_before = device.last_read = Instant::min();
    }
    for (auto& request : requests_) {
        request.repeat = request.repeat || request.modifying;
        if (request.read_back_since) request.read_back_since = kMayBeReadBack;
    }
    for (auto& [id, command] : commands_) {
        if (command.modifying) command.waits = command.repeat = true;
        if (command.read_back_since) command.read_back_since = kMayBeReadBack;
    }
}

void LineJudge::settle(Transaction& transaction, Instant t) {
    transaction.over = true;
    const bool closed = transaction.close != Close::none;
    const bool of_several = transaction.close == Close::of_several;
    const Duration occupied = std::max(
        std::min(t, transaction.deadline) - transaction.start + arithmetic_.silence(), line_.request_gap);
    // With other bytes around the answer, the master's next action shows whether it found the answer.
    const bool failed = !transaction.answered() || transaction.unsure();
    settle_request(transaction, t);
    settle_writes(transaction, t);
    note_event_end(transaction, failed ? std::max(t, transaction.deadline) : t);
    if (closed)
        note_excess({.t = t,
                     .length = occupied,
                     .device = of_several ? std::nullopt : std::optional(transaction.device),
                     .unproved = transaction.event() && !transaction.expected});
    else if (failed)
        note_excess(excess_of_failure(transaction, t, occupied));
    else if (!transaction.polls() && !transaction.expected)
        note_excess({.t = t, .length = occupied, .device = {}, .bounded = transaction.client});
    else if (const auto more = beyond(transaction, occupied); more > Duration::zero())
        note_excess({t, more, {}});
    else if (in_doubt(transaction))
        note_excess(excess_of_confirmation(transaction, t));
    DeviceState& device = devices_[transaction.device];
    if (!failed) {
        answers_ = true;
        closes_.clear();
        const Duration took = transaction.heard_at - transaction.start;
        // The time of a response that may be that to an earlier request is not known.
        if (!in_doubt(transaction)) device.fastest = std::min(device.fastest.value_or(took), took);
    }
    if (closed && !of_several)
        note_trouble(device, t);
    else if (!closed && (failed || transaction.received.answer == Answer::exception))
        note_trouble(device, std::max(t, transaction.deadline) + hold_of(device));
    if (transaction.purpose == Purpose::trial) return;  // no evidence about the device
    if (of_several) return;
    if (transaction.cut || transaction.close == Close::perhaps_own) {
        ++device.possible;  // switched off and on again meanwhile, it is held against the device
        device.failed_by_close = false;
    } else {
        settle_device(transaction);
    }
}

// The line's rate limit of events counts from their ends.
void LineJudge::note_event_end(const Transaction& transaction, Instant end) {
    if (transaction.event()) written_until_ = std::max(written_until_, end);
    if (transaction.client && transaction.answered() && !transaction.unsure())
        client_end_ = std::max(client_end_, std::min(end, transaction.heard_at));
}

void LineJudge::settle_request(Transaction& transaction, Instant t) {
    if (!transaction.request || !transaction.is_its_read()) return;
    RequestState& request = requests_[*transaction.request];
    const bool failed = !transaction.answered() || transaction.unsure();
    const bool refused = transaction.received.answer == Answer::exception;
    if (transaction.purpose == Purpose::trigger)
        request.trigger_failed = failed || refused || transaction.partial;
    const bool learns = devices_[transaction.device].model->gaps == model::Gaps::learn;
    // After bytes that are no answer the master ends the connection itself: the attempt failed by them.
    const bool closed =
        transaction.close != Close::none && transaction.deadline > t && !transaction.heard_something;
    if (!failed) request.cuts = 0;
    if (closed && transaction.purpose != Purpose::trigger) ++request.cuts;
    // A read that the link was lost with is sent again at once, but not twice in a row.
    const bool again = (failed || transaction.partial || (refused && (learns || transaction.replaces))) &&
                       !(closed && request.cuts > 1 && transaction.purpose != Purpose::trigger);
    if (again && transaction.purpose == Purpose::trigger) {
        transaction.waits_again = !request.edge;
        request.edge = request.edge.value_or(transaction.start);
    } else if (transaction.polls() || transaction.purpose == Purpose::probe) {
        request.retry = again;
    }
    // The master may recognise at once that received bytes are no answer. A waiting repetition is not
    // shortened by a triggered read in between.
    if (transaction.purpose != Purpose::trigger || !request.retry) {
        request.failed_at = std::min(t, transaction.deadline);
        if (transaction.heard_something) request.failed_at = std::min(request.failed_at, heard_at_);
    }
    if (request.busy && !failed && !refused) ++recoveries_["busy_ended"];
    request.busy = refused && (transaction.received.exception == 5 || transaction.received.exception == 6);
    const bool of_several = transaction.close == Close::of_several;
    if (!of_several) request.failures = failed ? request.failures + 1 : 0;
    if (!of_several) request.held = failed || refused;
}

void LineJudge::settle_device(const Transaction& transaction) {
    DeviceState& device = devices_[transaction.device];
    if (transaction.answered()) {
        if (transaction.repeated && !transaction.unsure()) ++recoveries_["retried_and_got"];
        if (device.may_be_dead()) {
            came_back(transaction.device);
        }
        const unsigned possible = device.possible + 1;
        device.answers();
        if (transaction.unsure()) device.possible = possible;
        return;
    }
    ++device.possible;
    device.failed_by_close = transaction.close == Close::own;
    const bool others = std::ranges::any_of(transactions_, [&](const Transaction& other) {
        return &other != &transaction && !other.over && other.device == transaction.device;
    });
    if (device.dead() && others) return;
    const bool died = device.failures + 1 == device.model->attempts;
    device.failures = std::min(device.failures + 1, unsigned{device.model->attempts});
    if (died && device.has_reads) drop_triggered(transaction.device);
    if (!device.dead()) return;
    if (transaction.early) {
        if (transaction.request)
            device.probe_not_before = std::max(
                device.probe_not_before, transaction.start + probe_period(device, *transaction.request));
        return;
    }
    const auto& backoff = device.model->backoff.value_or(case_.project.backoff);
    const auto wait =
        std::min(backoff.limit, backoff.first * (std::int64_t{1} << std::min(device.probes, 20U)));
    device.probe_not_before = transaction.end + wait;
    ++device.probes;
}

// The state of a device is reset.
void LineJudge::restart(std::size_t index, bool at_once) {
    for (auto& request : requests_) {
        if (request.plan->device != index) continue;
        request.at_once = at_once;
        request.retry = request.held = false;
        request.failures = 0;
    }
}

Duration LineJudge::all_once(std::size_t index) const {
    Duration all{};
    for (const auto& request : requests_)
        if (request.plan->device == index) all += request.plan->bus_time;
    return all;
}

void LineJudge::came_back(std::size_t index) {
    const bool dead = devices_[index].dead();
    if (dead) ++recoveries_["device_came_back"];
    for (auto& request : requests_) {
        if (request.plan->device != index) continue;
        // After closes it answered some reads: they keep their periods.
        request.at_once = request.at_once || !devices_[index].failed_by_close;
        if (!dead) continue;  // perhaps
        request.held = false;
        request.failures = 0;
    }
    note_excess({busy_until_, all_once(index), {}});
    note_trouble(devices_[index], busy_until_);
}

void LineJudge::note_trouble(DeviceState& device, Instant until) {
    device.clean_from = std::max(device.clean_from, until);
}

// At most eight time-outs after a late response, docs/guarantees.md, "Late responses".
Duration LineJudge::hold_of(const DeviceState& device) const {
    constexpr int kLongest = 8;
    const Duration least = device.model->response_timeout;
    return ledger_.lateness(device.model->address.value) > Duration::zero() ? kLongest * least : least;
}

LineJudge::Excess LineJudge::excess_of_failure(const Transaction& transaction, Instant t,
                                               Duration occupied) const {
    return {.t = t,
            .length = std::max(occupied, transaction.failure),
            .device = transaction.device,
            .hold = transaction.failure + hold_of(devices_[transaction.device]),
            .unproved = transaction.event() && !transaction.expected};
}

// A further frame is waited for. If none comes, the unit may be held back.
LineJudge::Excess LineJudge::excess_of_confirmation(const Transaction& transaction, Instant t) const {
    return {.t = t,
            .length = transaction.failure,
            .device = transaction.device,
            .hold = hold_of(devices_[transaction.device])};
}

void LineJudge::note_excess(const Excess& excess) {
    excess_.push_back(excess);
    while (excess_.front().t < excess.t - kRemembered) {
        forgotten_ = std::max(forgotten_, excess_.front().t + excess_.front().length);
        excess_.pop_front();
    }
}

Transaction* LineJudge::outstanding(std::uint8_t unit) {
    for (Transaction& transaction : transactions_)
        if (!transaction.over && transaction.asked.unit == unit) return &transaction;
    return nullptr;
}

void LineJudge::on_fault(const sim::FaultEvent& event) {
    using sim::FaultKind;
    const Instant until = event.until.value_or(event.time);
    constexpr Duration kNoise = std::chrono::milliseconds(40);
    if (event.kind == FaultKind::ignored_write) return note_ignored(event.time, *event.device);
    if (event.kind == FaultKind::clock_jump) stood_still_until_ = std::max(stood_still_until_, until);
    // A babbling device blocks the line for all.
    const bool babble = event.kind == FaultKind::device_babbles;
    const Duration blocked = event.device && !babble ? Duration::zero() : until - event.time;
    note_excess({event.time, blocked + kNoise, {}});
    // While no request can be sent, no device answers: back-offs begin.
    const auto asleep_over = [&](const DeviceState& device) {
        return event.kind == FaultKind::clock_jump &&
               std::ranges::any_of(transactions_, [&](const Transaction& transaction) {
                   return !transaction.over && &devices_[transaction.device] == &device;
               });
    };
    for (auto& device : devices_) {
        if (event.device && !babble && &device != &devices_[*event.device]) continue;
        const auto& backoff = device.model->backoff.value_or(case_.project.backoff);
        note_trouble(device, until + device.model->response_timeout + kNoise +
                                 (babble || asleep_over(device) ? backoff.limit : Duration::zero()));
    }
}

}  // namespace takt::judge
