// In step: what follows from reads that were sent in the place of planned ones, and from late responses
// (docs/decisions/0032-in-step.md). RequestOffers decides which read is sent.
#include <utility>

#include "line/run.hpp"

namespace takt::poll {

using Proof = bus::StepWatch::Proof;
using value::Quality;
using value::Reason;

// @returns whether the read that was sent instead is settled by this
bool LinePoller::Run::on_part(const bus::Outcome& outcome, const OutcomeClass& outcome_class,
                              std::size_t index) {
    using Ended = DistinctReads::Ended;
    const Ended ended = distinct_reads_.ended(index, outcome_class);
    if (ended == Ended::planned) return false;
    if (ended == Ended::part) take_values(outcome, index, outcome.request, false);
    reads_.again(outcome.ended_at, index);
    return true;
}

void LinePoller::Run::set_times(const DeviceRun& device, bus::Transaction& transaction) const {
    transaction.wait = device.delay_learner.wait();
    device.times.set(transaction, device.model->response_timeout);
}

void LinePoller::Run::note_in_step(const bus::Outcome& outcome) {
    if (engine_.config().framing == wire::Framing::tcp) return;
    const auto index = device_at(outcome.unit);
    if (!index) return;
    auto& times = devices_[*index].times;
    times.step.on_outcome(outcome, times.in_order);
    settle_held(outcome.ended_at, *index);
}

void LinePoller::Run::on_surplus(const bus::SurplusFrame& frame) {
    const auto index = device_at(frame.unit);
    if (!index) return;
    auto& device = devices_[*index];
    if (engine_.config().framing == wire::Framing::tcp) {  // it can answer no other request
        ++device.statistics.surplus;
        return;
    }
    const auto since = device.times.step.on_surplus(frame);
    settle_held(frame.at, *index);
    if (since) degrade_shifted(frame.at, device, frame.shape, *since);
    const Surplus found{.at = frame.at, .device = *index, .shifted = since.has_value()};
    if (engine_.awaited() && !undecided_surplus_)
        undecided_surplus_ = found;
    else
        count_surplus(found);
}

void LinePoller::Run::count_surplus(const Surplus& found) {
    auto& statistics = devices_[found.device].statistics;
    ++statistics.surplus;
    if (found.shifted && !std::exchange(statistics.shifted, true) && observer_)
        observer_->on_surplus(found.at, plan_->line, found.device);
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

// While the unit is in doubt, the values are held back, and shown as uncertain.
void LinePoller::Run::take_values(const bus::Outcome& outcome, std::size_t index,
                                  const wire::RequestShape& sent, bool whole) {
    const std::size_t device = requests_[index].device;
    auto& held = devices_[device].held;
    const HeldRead read{
        .request = index, .sent = sent, .round = reads_.round(index), .whole = whole, .outcome = outcome};
    const auto quality = quality_of(outcome.ended_at, device, outcome);
    if (held.empty() && quality) return publish_read(read, *quality);
    show_doubt(read);
    if (held.full()) pop_held(device, Quality::uncertain);
    held.add(read);
    ++held_reads_;
}

void LinePoller::Run::show_doubt(const HeldRead& read) {
    publisher_.degrade(read.outcome.ended_at, requests_[read.request].variables, Quality::uncertain,
                       Reason::ambiguous, Shown::last);
}

void LinePoller::Run::publish_read(const HeldRead& read, Quality quality) {
    const auto& outcome = read.outcome;
    publisher_.take(outcome, read.request, read.sent, read.round, quality);
    if (quality != Quality::good) return;
    if (read.whole)
        ages_->note_read(requests_[read.request].variables, outcome.sent_at, outcome.ended_at);
    else
        ages_->note_updates(publisher_.updates(), outcome.sent_at, outcome.ended_at);
}

void LinePoller::Run::pop_held(std::size_t device, Quality quality) {
    auto& held = devices_[device].held;
    publish_read(held.front(), quality);
    held.pop();
    --held_reads_;
}

// Nothing: it is not decided. If it is not decided for a check interval, the values are uncertain.
std::optional<Quality> LinePoller::Run::quality_of(Instant t, std::size_t device,
                                                   const bus::Outcome& read) const {
    if (engine_.config().framing == wire::Framing::tcp) return Quality::good;
    const Proof proof = devices_[device].times.step.proof(t, read);
    const bool too_long = t > after(read.ended_at, bus::StepWatch::kInterval);
    if (proof == Proof::proved && !too_long) return Quality::good;
    if (proof != Proof::waits || too_long || suspended_) return Quality::uncertain;
    return std::nullopt;
}

void LinePoller::Run::settle_held(Instant t, std::size_t device) {
    auto& held = devices_[device].held;
    if (held.empty()) return;
    while (!held.empty()) {
        const auto quality = quality_of(t, device, held.front().outcome);
        if (!quality) break;
        pop_held(device, *quality);
    }
    // A value that was good just now is in doubt again since the next read of it: no later mark, of its age
    // or of a further read, may go before that read.
    for (const auto& read : held.all()) show_doubt(read);
    expire_ages(t);  // of those that are too old by now
}

void LinePoller::Run::settle_held(Instant t) {
    for (std::size_t d = 0; held_reads_ > 0 && d < devices_.size(); ++d) settle_held(t, d);
}

// Before other values of the device follow.
void LinePoller::Run::give_up_held(std::size_t device) {
    while (!devices_[device].held.empty()) pop_held(device, Quality::uncertain);
}

void LinePoller::Run::give_up_held() {
    for (std::size_t d = 0; d < devices_.size(); ++d) give_up_held(d);
}

Instant LinePoller::Run::held_until() const {
    Instant until = kNever;
    if (held_reads_ == 0) return until;
    for (const auto& device : devices_) {
        if (device.held.empty()) continue;
        const auto& outcome = device.held.front().outcome;
        until = std::min({until, device.times.step.doubted_until(outcome),
                          after(outcome.ended_at, bus::StepWatch::kInterval + Duration(1))});
    }
    return until;
}

}  // namespace takt::poll
