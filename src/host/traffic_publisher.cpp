#include "traffic_publisher.hpp"

#include <algorithm>

#include "record_codec.hpp"
#include "takt/line/loop.hpp"

namespace takt::host {

void TrafficPublisher::on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) {
    put(t, direction, unit, std::nullopt, pdu, raw);
}

void TrafficPublisher::on_fault(Instant t, wire::FrameFault fault, Bytes raw) {
    put(t, wire::Direction::received, {}, fault, {}, raw);
}

void TrafficPublisher::put(Instant t, wire::Direction direction, UnitId unit,
                           std::optional<wire::FrameFault> fault, Bytes pdu, Bytes raw) {
    if (link_.taps.load(std::memory_order_relaxed) == 0) return;
    // A connection answers at the time of the request; its answer is sent at the end of the work.
    if (direction == wire::Direction::sent && !peer_.empty()) t = std::max(t, line::now());
    record_.clear();
    encode({.generation = generation_,
            .source = source_,
            .t = t,
            .direction = direction,
            .unit = unit,
            .fault = fault,
            .peer = peer_.view(),
            .pdu = pdu,
            .raw = raw},
           record_);
    link_.traffic.append(record_);
}

}  // namespace takt::host
