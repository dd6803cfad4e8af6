// In step: what follows from reads that were sent in the place of planned ones, and from late responses
// (docs/decisions/0032-in-step.md). RequestOffers decides which read is sent.
#include <utility>

#include "run.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

// @returns whether the read that was sent instead is settled by this
bool LinePoller::Run::on_part(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                              std::size_t index) {
    using Ended = DistinctReads::Ended;
    const Ended ended = distinct_reads_.ended(index, outcome_class);
    if (ended == Ended::planned) return false;
    if (ended == Ended::part) {
        publisher_.take(outcome, index, outcome.request);
        ages_->note_updates(publisher_.updates(), outcome.sent_at, outcome.ended_at);
    }
    reads_.again(outcome.ended_at, index);
    return true;
}

void LinePoller::Run::set_times(const DeviceRun& device, bus::Transaction& transaction) const {
    transaction.wait = device.delay_learner.wait();
    device.times.set(transaction, device.model->response_timeout);
}

void LinePoller::Run::note_in_step(const bus::Outcome& outcome) {
    if (engine_.config().framing == wire::Framing::tcp) return;
    if (const auto index = device_at(outcome.unit)) devices_[*index].times.step.on_outcome(outcome);
}

void LinePoller::Run::on_surplus(const bus::SurplusFrame& frame) {
    const auto index = device_at(frame.unit);
    if (!index) return;
    auto& device = devices_[*index];
    ++device.statistics.surplus;
    const auto since = device.times.step.on_surplus(frame);
    if (!since) return;
    degrade_shifted(frame.at, device, frame.shape, *since);
    if (!std::exchange(device.statistics.shifted, true) && observer_)
        observer_->on_surplus(frame.at, plan_->line, *index);
}

// The values of responses like that one (an exception is like all of its function) that were read since.
void LinePoller::Run::degrade_shifted(Instant t, const DeviceRun& device, const bus::AnswerShape& shape,
                                      Instant since) {
    for (const auto r : device.requests) {
        const auto& read = requests_[r].read;
        if (!read || read->last_start < since || read->shape().function != shape.function) continue;
        if (shape.pdu_length != 0 && read->shape() != shape) continue;
        publisher_.degrade(t, requests_[r].variables, Quality::uncertain, Reason::ambiguous, Shown::last);
    }
}

}  // namespace takt::poll
