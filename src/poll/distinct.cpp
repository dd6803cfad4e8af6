// In step: what follows from reads that were sent in the place of planned ones, and from late responses
// (docs/decisions/0032-in-step.md). RequestOffers decides which read is sent.
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
        publisher_.take(outcome.ended_at, index, outcome.request, outcome.response);
        ages_->note_updates(publisher_.updates(), outcome.sent_at, outcome.ended_at);
    }
    reads_.again(outcome.ended_at, index);
    return true;
}

void LinePoller::Run::set_times(const DeviceRun& device, bus::Transaction& transaction) const {
    transaction.wait = device.delay_learner.wait();
    device.times.set(transaction, device.model->response_timeout);
}

void LinePoller::Run::degrade_shifted(const DeviceRun& device, const bus::LateResponse& late) {
    if (!late.out_of_order_since) return;
    for (const auto r : device.requests) {
        const auto& read = requests_[r].read;
        if (read && read->shape() == late.shape && read->last_start >= *late.out_of_order_since)
            publisher_.degrade(late.at, requests_[r].variables, Quality::uncertain, Reason::ambiguous,
                               Shown::last);
    }
}

}  // namespace takt::poll
