// Transactions of clients that share the line. They are sent when no other request is due, or before polling
// if the line had relay_interval without one (bus::TransactionGate). The guarantees include this rate. Those
// for spare time are sent only where they have ended, answered or not, before anything is due.
#include <algorithm>

#include "line/run.hpp"
#include "takt/bus/failure_time.hpp"

namespace takt::poll {

void LinePoller::Run::share_line() {
    if (line_.relayed) relay_ = std::make_unique<RelaySlot>(line_.relay_interval);
}

void LinePoller::Run::admit_guests() {
    if (!relay_) relay_ = std::make_unique<RelaySlot>(std::nullopt);
}

Result<void> LinePoller::Run::relay(Instant t, const bus::Transaction& transaction, bool spare) {
    if (!relay_) return fail(Code::unsupported, line_.name);
    if (!relay_->empty()) return fail(Code::queue_full, 1);
    if (!link_.usable()) return fail(Code::connection_lost);
    bus::Transaction relayed = transaction;
    const auto device = device_at(transaction.unit);
    if (device) set_times(devices_[*device], relayed);
    // One that waits for spare time would keep those of the gateway from being sent.
    if (spare && line_.relayed) {
        relayed.wait = std::min(relayed.wait, line_.relayed->response_timeout);
        spare = false;
    }
    TAKT_CHECK(relay_->put(relayed, device, spare));
    if (device && devices_[*device].health.enabled() && !reachable(devices_[*device]))
        give_up_relayed(t, bus::Status::timeout);
    else
        arbiter_.wake_at(t);
    return {};
}

bool LinePoller::Run::device_takes_relayed(Instant t) const {
    const auto index = relay_->device();
    if (!index) return true;
    const auto& device = devices_[*index];
    if (full(device) || (device.writing && !relay_->only_reads())) return false;
    // While its response may still come late, polling of the device is held back. The next one must not
    // renew that.
    return !device.relayed_last || !reachable(device) || !reads_.any_due(t, *index);
}

void LinePoller::Run::offer_relayed(Instant t) {
    if (relay_ && relay_->waiting() && !relay_->spare() && device_takes_relayed(t)) put_offer_of_relayed(t);
}

void LinePoller::Run::offer_spare_relayed(Instant t) {
    if (!relay_ || !relay_->waiting() || !relay_->spare() || !device_takes_relayed(t)) return;
    const auto& transaction = relay_->transaction();
    const Duration lost = bus::failure_time(engine_.config(), transaction.request.pdu().size(),
                                            relay_->shape().pdu_length, transaction.wait);
    if (offers_.is_spare(t, lost)) put_offer_of_relayed(t);
}

void LinePoller::Run::put_offer_of_relayed(Instant t) {
    const auto device = relay_->device();
    const Instant due = device ? devices_[*device].times.step.earliest_relayed(t, relay_->shape()) : t;
    offers_.offer(t, relay_->unit(), relay_->shape(), due, relay_->candidate(t));
}

void LinePoller::Run::start_relayed(Instant t) {
    if (const auto device = relay_->device()) devices_[*device].relayed_last = true;
    if (engine_.submit(t, relay_->start(t))) return relay_->submitted(t);
    give_up_relayed(t, bus::Status::link_lost);  // a broadcast that is not a write
}

void LinePoller::Run::on_relayed(const bus::Outcome& outcome) {
    note_busy(outcome);
    if (relay_->end(outcome, offers_.line_free()) && outcome.status == bus::Status::timeout)
        check_connection(outcome.ended_at);
}

void LinePoller::Run::give_up_relayed(Instant t, bus::Status status) {
    if (relay_) relay_->give_up(t, status, offers_.line_free());
}

}  // namespace takt::poll
