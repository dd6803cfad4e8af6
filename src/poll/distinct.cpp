// In step: which read is sent while responses are outstanding, and what late ones show of their device
// (docs/decisions/0032-in-step.md).
#include <algorithm>

#include "run.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

// Computed when they are needed for the first time: a line without failures needs none.
const plan::ReadAlternative* LinePoller::Run::alternative_to(Instant t, std::size_t index) {
    if (!distinct_reads_ || !engine_.any_ambiguity(t)) return nullptr;
    auto& request = requests_[index];
    auto& device = devices_[request.device];
    const UnitId unit = device.model->address;
    const auto planned = engine_.ambiguity(t, unit, request.read->shape());
    if (planned == bus::Ambiguity::none) return nullptr;
    if (!request.read->distinct) {
        if (!device.alternatives)
            device.alternatives =
                HeapOptional(plan::AlternativeReads(project_, line_, *device.model, plan_->requests));
        request.read->distinct = HeapOptional(DistinctRead(device.alternatives->of(*request.plan)));
    }
    return request.read->distinct->choose(planned, [&](wire::Function read, std::uint16_t quantity) {
        return engine_.ambiguity(t, unit, bus::answer_shape(read, quantity));
    });
}

bus::AnswerShape LinePoller::Run::shape_to_send(Instant t, std::size_t index) {
    const auto* instead = alternative_to(t, index);
    if (!instead) return requests_[index].read->shape();
    return bus::answer_shape(instead->read, instead->quantity);
}

wire::PreparedRead LinePoller::Run::read_to_send(Instant t, std::size_t index) {
    auto& read = *requests_[index].read;
    const auto* instead = alternative_to(t, index);
    if (read.distinct) read.distinct->send(instead);
    if (!instead) return read.request;
    return prepared({instead->read, DataAddress{instead->start}, instead->quantity});
}

// @returns whether the read that was sent instead is settled by this
bool LinePoller::Run::on_part(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                              RequestRun& request) {
    auto& distinct = *request.read->distinct;
    const auto* sent = distinct.sent();
    const bool whole = distinct.whole();
    if (outcome_class.reason == Reason::ok && whole) distinct.on_answered();
    if (!sent || outcome_class.transient()) return false;
    if (outcome_class.reason != Reason::ok) {
        distinct.on_refused();
    } else if (whole) {
        return false;
    } else {
        distinct.on_part_answered();
        if (sent->kind == plan::ReadAlternative::Kind::part) {
            take_values(outcome.ended_at, request, outcome.request, outcome.response);
            ages_->note_updates(updates_, outcome.sent_at, outcome.ended_at);
        }
    }
    read_again(outcome.ended_at, request);
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
            degrade(late.at, requests_[r].variables, Quality::uncertain, Reason::ambiguous, false);
    }
}

}  // namespace takt::poll
