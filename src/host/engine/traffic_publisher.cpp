#include "engine/traffic_publisher.hpp"

#include <algorithm>

#include "takt/line/loop.hpp"

namespace takt::host {

void TrafficPublisher::on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) {
    put({.t = t, .direction = direction, .unit = unit, .pdu = pdu, .raw = raw});
}

void TrafficPublisher::on_fault(Instant t, wire::FrameFault fault, Bytes raw) {
    put({.t = t, .direction = wire::Direction::received, .fault = fault, .raw = raw});
}

void TrafficPublisher::on_incident(Instant t, UnitId unit, wire::Incident incident, Duration after,
                                   const std::optional<Mismatch>& instead) {
    put({.t = t,
         .direction = wire::Direction::received,
         .unit = unit,
         .incident = incident,
         .after = after,
         .instead = instead});
}

void TrafficPublisher::put(TrafficView view) {
    if (link_.taps.load(std::memory_order_relaxed) == 0) return;
    // A connection answers at the time of the request; its answer is sent at the end of the work.
    if (view.direction == wire::Direction::sent && !peer_.empty()) view.t = std::max(view.t, line::now());
    view.generation = generation_;
    view.source = source_;
    view.peer = peer_.view();
    record_.clear();
    encode(view, record_);
    link_.traffic.append(record_);
}

}  // namespace takt::host
