// Transactions of clients that share the line. They are sent when no other request is due, or before polling
// if the line had relay_interval without one (bus::TransactionGate). The guarantees include this rate.
#include <algorithm>
#include <utility>

#include "run.hpp"

namespace takt::poll {

void LinePoller::Run::share_line() {
    if (!line_.relayed) return;
    relay_ = std::make_unique<RelayRun>(RelayRun{.gate = {1, line_.relay_interval}});
}

Result<void> LinePoller::Run::relay(Instant t, const bus::Transaction& transaction) {
    if (!relay_) return fail(Code::unsupported, line_.name);
    if (relay_->transaction || relay_->outcome) return fail(Code::queue_full, 1);
    if (!engine_.link_up()) return fail(Code::connection_lost);
    if (transaction.request.empty()) return fail(Code::out_of_range, 0, 1, wire::kMaxPdu);
    relay_->transaction = transaction;
    relay_->only_reads = transaction.request.only_reads();
    relay_->device.reset();
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (devices_[d].model->address == transaction.unit) relay_->device = d;
    if (relay_->device) {
        const auto& device = devices_[*relay_->device];
        if (device.enabled && !reachable(device)) {
            give_up_relayed(t, bus::Status::timeout);
            return {};
        }
        relay_->transaction->wait = device.wait;
        relay_->transaction->late_limit = device.model->response_timeout;
    }
    wake_at(t);
    return {};
}

void LinePoller::Run::consider_relayed(Instant t, std::optional<Candidate>& best) {
    if (!relay_ || !relay_->transaction || relay_->in_flight) return;
    if (relay_->device) {
        const auto& device = devices_[*relay_->device];
        if (full(device) || (device.writing && !relay_->only_reads)) return;
        // While its response may still come late, polling of the device is held back. The next one must not
        // renew that.
        if (device.relayed_last && polling_waits(t, device)) return;
    }
    const Candidate candidate{relay_->gate.admits(t) ? Urgency::relayed : Urgency::background,
                              relay_->last_start.time_since_epoch().count(), 0, JobKind::relayed, 0};
    const auto& transaction = *relay_->transaction;
    consider(t, transaction.unit, bus::answer_shape(transaction.request.shape()), Instant::min(), candidate,
             best);
}

bool LinePoller::Run::polling_waits(Instant t, const DeviceRun& device) const {
    return reachable(device) && std::ranges::any_of(device.requests, [&](std::size_t index) {
               const auto& request = requests_[index];
               return request.read && request.read->polled && !request.read->in_flight &&
                      request.plan->period > Duration::zero() && request.read->polling_due() <= t;
           });
}

void LinePoller::Run::start_relayed(Instant t) {
    relay_->last_start = t;
    if (relay_->device) devices_[*relay_->device].relayed_last = true;
    bus::Transaction transaction = *relay_->transaction;
    transaction.id = transaction_id(JobKind::relayed, 0);
    relay_->in_flight = engine_.submit(t, transaction).has_value();
    if (relay_->in_flight) return relay_->gate.started(t);
    drop_relayed(t);  // a broadcast that is not a write
}

// The outcome of a transaction that drop_relayed() gave up is ignored.
void LinePoller::Run::on_relayed(const bus::Outcome& outcome) {
    note_busy(outcome);
    if (!relay_->in_flight) return;
    if (outcome.status == bus::Status::timeout) check_connection(outcome.ended_at);
    finish_relayed(outcome);
}

void LinePoller::Run::finish_relayed(bus::Outcome outcome) {
    if (std::exchange(relay_->in_flight, false)) relay_->gate.ended(std::max(outcome.ended_at, line_free()));
    outcome.id = relay_->transaction->id;
    relay_->transaction.reset();
    relay_->response.assign(outcome.response.pdu());
    outcome.response = outcome.response.moved_to(relay_->response.span());
    relay_->outcome = outcome;
}

void LinePoller::Run::drop_relayed(Instant t) {
    if (relay_ && relay_->transaction) give_up_relayed(t, bus::Status::link_lost);
}

// Without sending it.
void LinePoller::Run::give_up_relayed(Instant t, bus::Status status) {
    finish_relayed({.id = 0,
                    .unit = relay_->transaction->unit,
                    .status = status,
                    .sent_at = t,
                    .request_end = t,
                    .ended_at = t});
}

}  // namespace takt::poll
