#include "devices/exchange_times.hpp"

#include <algorithm>

namespace takt::poll {

void ExchangeTimes::on_response(const bus::LineConfig& config, const bus::Outcome& outcome, Duration delay) {
    record(turnaround_, std::max(delay, Duration::zero()));
    const Duration request = outcome.request_end - outcome.sent_at;
    if (config.framing == wire::Framing::tcp || request == Duration::zero()) return;  // a network
    record(wire_, request + config.frame_time(outcome.response.pdu().size()));
}

LineTimes ExchangeTimes::times() const {
    return {snapshot_of(wire_), snapshot_of(turnaround_), snapshot_of(host_)};
}

void ExchangeTimes::record(Times& times, Duration sample) {
    if (!times) times = HeapOptional(CompactLatencyStatistics());
    times->record(sample);
}

}  // namespace takt::poll
