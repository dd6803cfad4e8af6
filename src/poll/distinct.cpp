// In step: which read is sent while responses are outstanding, and what late ones show of their device
// (docs/decisions/0032-in-step.md).
#include <algorithm>

#include "run.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

const plan::ReadAlternative* LinePoller::Run::alternative_to(Instant t, std::size_t index) {
    if (!sends_distinct_ || !engine_.any_ambiguity(t)) return nullptr;
    const auto& request = requests_[index];
    const UnitId unit = devices_[request.device].model->address;
    const auto planned = engine_.ambiguity(t, unit, request.read->shape());
    if (planned == bus::Ambiguity::none) return nullptr;
    return distinct_reads_.choose(index, planned, [&](wire::Function read, std::uint16_t quantity) {
        return engine_.ambiguity(t, unit, bus::answer_shape(read, quantity));
    });
}

bus::AnswerShape LinePoller::Run::shape_to_send(Instant t, std::size_t index) {
    const auto* instead = alternative_to(t, index);
    if (!instead) return requests_[index].read->shape();
    return bus::answer_shape(instead->read, instead->quantity);
}

wire::PreparedRead LinePoller::Run::read_to_send(Instant t, std::size_t index) {
    const auto* instead = alternative_to(t, index);
    distinct_reads_.send(index, instead);
    if (!instead) return requests_[index].read->request;
    return prepared({instead->read, DataAddress{instead->start}, instead->quantity});
}

// @returns whether the read that was sent instead is settled by this
bool LinePoller::Run::on_part(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                              std::size_t index) {
    using Ended = DistinctReads::Ended;
    const bool ok = outcome_class.reason == Reason::ok;
    const Ended ended = distinct_reads_.ended(index, ok, outcome_class.transient());
    if (ended == Ended::planned) return false;
    if (ended == Ended::part) {
        publisher_.take(outcome.ended_at, index, outcome.request, outcome.response);
        ages_->note_updates(publisher_.updates(), outcome.sent_at, outcome.ended_at);
    }
    read_again(outcome.ended_at, requests_[index]);
    return true;
}

void LinePoller::Run::set_times(const DeviceRun& device, bus::Transaction& transaction) const {
    transaction.wait = device.wait;
    device.times.set(transaction, device.model->response_timeout);
}

void LinePoller::Run::degrade_shifted(const DeviceRun& device, const bus::LateResponse& late) {
    if (!late.out_of_order_since) return;
    for (const auto r : device.requests) {
        const auto& read = requests_[r].read;
        if (read && read->shape() == late.shape && read->last_start >= *late.out_of_order_since)
            publisher_.degrade(late.at, requests_[r].variables, Quality::uncertain, Reason::ambiguous, false);
    }
}

}  // namespace takt::poll
