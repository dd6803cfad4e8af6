#include "line/relay_slot.hpp"

#include <algorithm>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::poll {

Result<void> RelaySlot::put(const bus::Transaction& transaction, std::optional<std::size_t> device,
                            bool spare) {
    TAKT_ASSERT(empty());
    if (transaction.request.empty()) return fail(Code::out_of_range, 0, 1, wire::kMaxPdu);
    transaction_ = transaction;
    device_ = device;
    only_reads_ = transaction.request.only_reads();
    spare_ = spare;
    return {};
}

bool RelaySlot::withdraw() {
    if (!waiting()) return false;
    transaction_.reset();
    return true;
}

std::optional<bus::Outcome> RelaySlot::take_outcome() {
    return std::exchange(outcome_, std::nullopt);
}

Candidate RelaySlot::candidate(Instant t) const {
    return {.urgency = gate_ && gate_->admits(t) ? Urgency::relayed : Urgency::background,
            .key = last_start_.time_since_epoch().count(),
            .job = transaction_id(JobKind::relayed, 0)};
}

bus::Transaction RelaySlot::start(Instant t) {
    last_start_ = t;
    bus::Transaction transaction = *transaction_;
    transaction.id = transaction_id(JobKind::relayed, 0);
    return transaction;
}

void RelaySlot::submitted(Instant t) {
    in_flight_ = true;
    if (gate_) gate_->started(t);
}

bool RelaySlot::end(const bus::Outcome& outcome, Instant line_free) {
    if (!in_flight_) return false;
    finish(outcome, line_free);
    return true;
}

void RelaySlot::give_up(Instant t, bus::Status status, Instant line_free) {
    if (!transaction_) return;
    finish({.id = 0,
            .unit = transaction_->unit,
            .status = status,
            .sent_at = t,
            .request_end = t,
            .ended_at = t},
           line_free);
}

void RelaySlot::finish(bus::Outcome outcome, Instant line_free) {
    if (std::exchange(in_flight_, false) && gate_) gate_->ended(std::max(outcome.ended_at, line_free));
    outcome.id = transaction_->id;
    transaction_.reset();
    response_.assign(outcome.response.pdu());
    outcome.response = outcome.response.moved_to(response_.span());
    outcome_ = outcome;
}

}  // namespace takt::poll
