#include "traffic_publisher.hpp"

#include "record_codec.hpp"

namespace takt::host {

void TrafficPublisher::on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) {
    put(t, direction, unit, std::nullopt, pdu, raw);
}

void TrafficPublisher::on_fault(Instant t, wire::FrameFault fault) {
    put(t, wire::Direction::received, {}, fault, {}, {});
}

void TrafficPublisher::put(Instant t, wire::Direction direction, UnitId unit,
                           std::optional<wire::FrameFault> fault, Bytes pdu, Bytes raw) {
    if (link_.taps.load(std::memory_order_relaxed) == 0) return;
    record_.clear();
    encode(generation_, source_, t, direction, unit, fault, pdu, raw, record_);
    link_.traffic.append(record_);
}

}  // namespace takt::host
