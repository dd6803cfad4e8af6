// silence_kept, transaction_within_f, dead_costs_probes, poll_enable_obeyed.
#include <algorithm>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

std::string ns(Duration time) {
    return std::to_string(time.count()) + " ns";
}

}  // namespace

void LineJudge::check_silence(Instant t) {
    if (last_start_ == Instant::min()) return;
    const Duration silence =
        one_at_a_time() || line_.frame_gap > Duration::zero() ? arithmetic_.silence() : Duration::zero();
    if (serial() && t - busy_until_ < silence)
        complain("silence_kept", t, "silence of at least " + ns(silence) + " before a request",
                 ns(t - busy_until_));
    if (t - last_start_ < line_.request_gap)
        complain("silence_kept", t, "at least " + ns(line_.request_gap) + " between the starts of requests",
                 ns(t - last_start_));
}

// A request may follow the answer to the previous one, bytes received instead of that answer, or its
// time-out. An incomplete echo counts as other bytes.
void LineJudge::check_free(Instant t) {
    if (!echo_.empty()) return;
    for (const Transaction& transaction : transactions_)
        if (!transaction.over && !transaction.heard_something && t < transaction.deadline)
            complain("silence_kept", t, "no request before the " + describe(transaction) + " is over",
                     "another request");
}

void LineJudge::check_probe(Instant t, const Transaction& transaction, const Claim& claim) {
    const DeviceState& device = devices_[transaction.device];
    if (!device.enabled)
        complain("poll_enable_obeyed", t, "nothing sent to " + device.model->name + ", which is switched off",
                 describe(transaction));
    if (!device.dead() || transaction.cut) return;
    if (claim.sending.early)
        check_early_probe(transaction, claim);
    else if (t < device.probe_not_before)
        complain("dead_costs_probes", t,
                 device.model->name + " has not answered " + std::to_string(device.failures) +
                     " times, and is left alone for " + ns(device.probe_not_before - t) + " more",
                 describe(transaction));
}

// Without a period the first back-off takes its place.
Duration LineJudge::probe_period(const DeviceState& device, std::size_t request) const {
    const Duration period = requests_[request].plan->period.value_or(Duration::zero());
    return period > Duration::zero() ? period : device.model->backoff.value_or(case_.project.backoff).first;
}

// A probe before its back-off has passed costs the others no time: nothing waits, and nothing is due before
// it has timed out. There is one in a period.
void LineJudge::check_early_probe(const Transaction& transaction, const Claim& claim) {
    const Instant t = claim.t;
    const std::string what =
        "no probe of " + devices_[transaction.device].model->name + " before its back-off ends";
    const DeviceState& probed = devices_[transaction.device];
    if (claim.sending.request && *claim.sending.request < requests_.size() &&
        t < after(probed.last_read, probe_period(probed, *claim.sending.request)))
        complain("dead_costs_probes", t, what + ", within a period of the one before", describe(transaction));
    const Instant end = t + (transaction.deadline - transaction.start);
    for (const auto& request : requests_) {
        const plan::Request& planned = *request.plan;
        if (!planned.read || planned.period.value_or(Duration::zero()) == Duration::zero()) continue;
        if (request.held || request.retry || request.at_once || !sendable(planned.device, t - Duration(1), t))
            continue;
        const bool waits = is_due(request, t);
        if (waits || first_release_after(request, t) < end)
            complain("dead_costs_probes", t,
                     what + ", the read from " + std::to_string(planned.start) + " of " +
                         devices_[planned.device].model->name + " is due sooner",
                     describe(transaction));
    }
}

// The engine counts transactions at their end.
void LineJudge::check_length(Instant t, const std::vector<std::uint64_t>& ended) {
    for (std::size_t d = 0; d < devices_.size() && d < ended.size(); ++d) {
        DeviceState& device = devices_[d];
        if (device.sent == device.ended && ended[d] == device.ended) continue;
        std::uint64_t may_be_open = 0;
        const Transaction* late = nullptr;
        for (const Transaction& transaction : transactions_) {
            if (transaction.device != d) continue;
            // A further frame may be waited for where an earlier answer is owed, after each of them.
            Instant end = transaction.deadline;
            if (in_doubt(transaction))
                end = std::max(end, ledger_.last_candidate(transaction.asked).value_or(end)) +
                      transaction.failure;
            if (end >= t)
                ++may_be_open;
            else if (t > transaction.deadline && transaction.received.answer == Answer::none)
                late = &transaction;
        }
        device.ended = ended[d];
        if (t <= stood_still_until_ + std::chrono::milliseconds(1) || !late) continue;
        if (device.sent - ended[d] > may_be_open)
            complain("transaction_within_f", t,
                     "over at the latest " + ns(late->deadline - late->start) + " after its start (F is " +
                         ns(late->failure) + ")",
                     describe(*late) + " is under way since " + ns(t - late->start));
    }
}

}  // namespace takt::judge
